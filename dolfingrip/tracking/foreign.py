"""Points that another program has tracked, as if they had been seen in a video."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import body, formats, order
from dolfingrip.tracking.asked import TrackAsked
from dolfingrip.tracking.formats import PointTable
from dolfingrip.tracking.plane import Length
from dolfingrip.tracking.points import TrackedPoints, Watched

LIKELY: Final = 0.6
"""A point of less likelihood is lost, as DeepLabCut's own cut-off has it."""
CALIBRATED: Final = 0.004
"""Standard deviation of a scale by a line that a person drew: 1 px of 300, and 0.2 % of a ruler."""
OUT_OF_PLANE: Final = 0.05
"""Part of the motion out of the plane of bending from which on it is a doubt."""


def is_points(file: Path) -> bool:
    """Say if a file has points, and no pictures.

    Args:
        file: by its ending.
    """
    return file.suffix.lower() in formats.READERS


def load(file: Path, request: TrackAsked, until_s: float) -> tuple[Watched, TrackAsked]:
    """Read points as those of a video.

    Args:
        file: of another program.
        request: what is told.
        until_s: time up to which they are read (s).

    Returns:
        The points, of which 1 px is 1 mm where the file's unit is no pixel, and what is told, in
        their coordinates.

    Raises:
        ConfigError: one line, where points, time or unit are missing.
    """
    table = formats.read(file)
    chosen, unit = _chosen(file, table, request), _unit(file, table, request)
    numbers = table.columns.index.to_numpy(dtype=float)
    time_s = table.time_s if request.frame_rate is None else numbers / request.frame_rate
    if time_s is None or not np.isfinite(time_s).all():
        raise ConfigError(f"{file}: no time in each frame; allowed: --frame-rate Hz")
    places = _places(table, [*chosen, *filter(None, [request.clamp_label])])
    places *= formats.MM.get(unit, 1.0)
    begins = _first_with_all(file, places, chosen)
    doubts = []
    if begins:
        doubts.append(f"in {begins} frames a point is not there yet; the next is taken for rest")
    since_s = time_s - time_s[0]
    kept = np.flatnonzero((since_s <= until_s) & (np.arange(len(since_s)) >= begins))
    places = places[kept]
    in_space = places.shape[2] == 3
    if in_space:
        places, off = _in_plane(places)
        if off > OUT_OF_PLANE:
            doubts.append(f"{100 * off:.0f} % of the motion is out of the plane of bending")
    turned = np.array([1.0, -1.0 if table.upwards else 1.0])
    corner, size_px = _frame(places * turned, unit, request)
    px = places * turned - corner
    clamp = None if request.clamp_px is None else request.clamp_px * turned - corner
    if request.clamp_label is not None:
        clamp, px = px[0, -1], px[:, :-1]
    frames = [f"{number:g}" for number in numbers[kept]]
    seen = np.isfinite(px).all(axis=2).astype(float)
    points = TrackedPoints(frames, since_s[kept], px, seen, unit="px" if unit == "px" else "mm")
    fingers = order.fingers(px[0], request.fingers)
    fingers = [way if body.clamp_end_first(px[:, way]) else way[::-1] for way in fingers]
    per_mm = table.px_per_mm if unit == "px" else 1.0
    watched = Watched(
        points, fingers, [], np.full(len(frames), np.nan), size_px,
        lengths=() if per_mm is None else (_calibration(size_px, per_mm),),
        in_space=in_space, doubts=doubts,
        notes=[f"from the clamp: {', '.join(chosen[i] for i in way)}" for way in fingers],
    )  # fmt: skip
    return watched, replace(request, clamp_px=clamp)


def _chosen(file: Path, table: PointTable, request: TrackAsked) -> list[str]:
    """Names of the points of a finger, without that of the clamp."""
    names = list(dict.fromkeys(name for name, _ in table.columns.columns))
    chosen = [*request.labels] or [name for name in names if name != request.clamp_label]
    for name in {*chosen, request.clamp_label} - {*names, None}:
        raise ConfigError(f"{name}: no point of {file}; allowed: {', '.join(names)}")
    return chosen


def _unit(file: Path, table: PointTable, request: TrackAsked) -> str:
    """Unit of the places."""
    unit = request.unit or table.unit
    if unit not in (*formats.MM, "px"):
        has = unit or "not told"
        raise ConfigError(f"{file}: its unit is {has}; allowed: --unit mm, cm, m, in or px")
    return unit


def _first_with_all(file: Path, places: np.ndarray, chosen: Sequence[str]) -> int:
    """The first frame in which all points are there."""
    there = np.isfinite(places).all(axis=2)
    begins = int(there.all(axis=1).argmax())
    if not there[begins].all() or len(chosen) < 2:
        shares = zip(chosen, there.mean(axis=0), strict=False)
        seen = ", ".join(f"{name} in {100 * share:.0f} % of the frames" for name, share in shares)
        raise ConfigError(
            f"{file}: {seen}; allowed: a frame with all of at least 2 points of a finger, which "
            '--points "base,mid,tip" can choose'
        )
    return begins


def _frame(
    places: np.ndarray, unit: str, request: TrackAsked
) -> tuple[np.ndarray, tuple[int, int]]:
    """Upper left corner of a picture that has all places, and its width and height.

    No file tells where the middle of the picture is: that of the points is taken.
    """
    low, high = np.nanmin(places, axis=(0, 1)), np.nanmax(places, axis=(0, 1))
    corner = np.zeros(2) if unit == "px" else low - (high - low).max()
    reach = np.array([high - corner, *(end for scale in request.scales for end in scale.ends_px)])
    width, height = np.maximum(low + high - 2 * corner, reach.max(axis=0)).round().astype(int) + 1
    return corner, (int(width), int(height))


def _calibration(size_px: tuple[int, int], per_mm: float) -> Length:
    """Half the picture's width as a length that the other program has calibrated."""
    ends = np.array([[0.25, 0.5], [0.75, 0.5]]) * np.array(size_px)
    length_mm = 0.5 * size_px[0] / per_mm
    return Length(ends, length_mm, CALIBRATED * length_mm)


def _places(table: PointTable, names: Sequence[str]) -> np.ndarray:
    """Places (frames, points, axes) in the file's unit; NaN where a point is lost."""
    axes = "xyz" if (names[0], "z") in table.columns else "xy"
    places = []
    for name in names:
        place = np.array([table.columns[name, axis] for axis in axes], dtype=float).T
        if (name, "likelihood") in table.columns:
            place[~(table.columns[name, "likelihood"] >= LIKELY)] = np.nan
        places.append(place)
    return np.stack(places, axis=1)


def _in_plane(places: np.ndarray) -> tuple[np.ndarray, float]:
    """Places (frames, points, 2) in the plane of bending, and the part of the motion out of it."""
    motion = (places - places[0]).reshape(-1, 3)
    motion = motion[np.isfinite(motion).all(axis=1)]
    shape = places[0] - places[0].mean(axis=0)
    axes = np.linalg.svd(np.vstack([motion, shape]), full_matrices=False)[2]
    size = float(np.linalg.norm(motion))
    return places @ axes[:2].T, float(np.linalg.norm(motion @ axes[2])) / max(size, 1e-9)

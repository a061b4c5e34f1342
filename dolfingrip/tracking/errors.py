"""What all frames of a video share: errors of the camera, as a diagnosis takes them out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.channels import ANGLE, TIME, marker
from dolfingrip.clock import Clock
from dolfingrip.extensions.camera import carried
from dolfingrip.extensions.effect import Displaying
from dolfingrip.extensions.index import camera_errors
from dolfingrip.sections.fixture import Camera
from dolfingrip.tracking.body import Body
from dolfingrip.tracking.plane import Calibration

AIMED_DEG: Final = 2.0
"""Standard deviation of the tilt of a camera on a stand that was aimed squarely by eye."""
CLAMP_PX: Final = 1.0
"""Standard deviation of where a person points at the clamp, each way."""
MARK_MM: Final = 0.5
"""Standard deviation of a finger's back from the mark of the sheet, each way."""

SLOW_PX: Final = 0.07
"""Standard deviation of a place that changes slowly, with what is beside a mark as it moves; no
single frame shows it. It is 0.02 to 0.2 px in videos of dots of ``benchmarks/track``."""
SLOW_OVER_PX: Final = 2.0
"""Motion, of all marks together, within which that error fades. In six of these videos its
correlation is 0.8 up to 1 px, and 0.3 to 0.4 from 2 to 6 px."""


@dataclass(frozen=True)
class SharedErrors:
    """Errors of a camera, as a set-up tells them.

    Attributes:
        camera: set-up of the camera.
        stds: standard deviation by key of ``[nuisance]``.
        left: standard deviation of the readings that these leave, by column.
        fades_mm: motion of all marks within which that fades; None: it stays in all frames.
    """

    camera: Camera
    stds: Mapping[str, float]
    left: Mapping[str, float]
    fades_mm: float | None = None


def shared(body: Body, calibration: Calibration, clock: Clock | None) -> SharedErrors:
    """Tell the errors of a calibrated camera.

    Without a sheet a tilt is that of a camera which was aimed squarely: a diagnosis names one that
    is far larger. A motion capture has none. The lens, and whatever else cameras that fit what was
    seen do to the readings and none of these errors does, is left as noise that all frames share.

    Args:
        body: readings of a finger.
        calibration: of its camera.
        clock: that brought a log to the video; None: without a log.
    """
    camera, stds, mm_per_px = Camera(), dict[str, float](), 0.0
    stds["camera_tilt_deg"] = min(calibration.axis_std_deg, AIMED_DEG)
    if ANGLE.name in body.compared:
        stds["camera_zero_deg"] = rms(body.noise[ANGLE.name])
    if clock is not None:
        stds["camera_clock_s"] = clock.std_s
    if body.from_clamp:
        middle_px = (np.array(calibration.size_px) - 1) / 2
        mm_per_px, stds["camera_scale"] = calibration.square.scale(middle_px)
        stds["camera_zero_mm"] = MARK_MM if calibration.has_sheet else CLAMP_PX * mm_per_px

        def places(px: np.ndarray) -> tuple[tuple[float, float], ...]:
            plane_mm = body.frame.of(calibration.plane_mm(px))
            return tuple((float(x), float(z)) for x, z in plane_mm.round(3))

        ends_px = calibration.ends_px
        at_rest = [[float(x), float(z)] for x, z in body.rest_mm.round(3)]
        camera = Camera.model_validate({
            "markers": len(at_rest) if body.on_back else at_rest,
            "distance_mm": round(calibration.distance_mm, 1),
            "centre_mm": places(middle_px[None])[0],
            "scale_mm": None if ends_px is None else places(ends_px),
        })  # fmt: skip
    left = _left(body, camera, stds)
    left |= {
        name: float(np.hypot(std, SLOW_PX * mm_per_px))
        for name, std in left.items() if name != ANGLE.name
    }  # fmt: skip
    return SharedErrors(camera, stds, left, SLOW_OVER_PX * mm_per_px or None)


def rms(values: np.ndarray) -> float:
    """Return the root mean square of values (frames,), of which some may be missing.

    Args:
        values: NaN where missing.
    """
    return float(np.sqrt(np.nanmean(values**2)))


def _left(body: Body, camera: Camera, stds: Mapping[str, float]) -> dict[str, float]:
    """Root mean square by column of what drawn cameras change and no error that is told does."""
    every = np.array([body.readings[name] for name in body.compared])
    seen = np.isfinite(every).all(axis=0)
    if not seen.any():
        return {name: rms(body.common[name]) for name in body.compared}
    true = dict(zip(body.compared, every[:, seen], strict=True))
    true[TIME.name] = np.arange(float(seen.sum()))
    columns = []
    for kind in camera_errors():
        for key, report in kind.told_by.items():
            if report.key in stds and key != "late_s":
                start = {**kind.neutral}
                off = kind(**{**start, key: start[key] + stds[report.key]})
                assert isinstance(off, Displaying)
                shown = true | dict(off.reading(true, camera))
                columns.append(np.concatenate([shown[name] - true[name] for name in body.compared]))
    changes = np.array([_change(body, draw, seen) for draw in body.draws]).T
    weights, *_ = np.linalg.lstsq(np.array(columns).T, changes, rcond=1e-6)
    left = changes - np.array(columns).T @ weights
    parts = np.split(left, len(body.compared))
    return {name: rms(part) for name, part in zip(body.compared, parts, strict=True)}


def _change(body: Body, draw: Mapping[str, np.ndarray], seen: np.ndarray) -> np.ndarray:
    """Differences (columns · rows,) of what another camera tells of the same points of the body.

    Points are told by where they seemed to rest, so those are followed in what it tells.
    """
    other = {name: draw[name][seen] for name in body.compared}
    if body.from_clamp and not body.on_back:
        names = [[marker(i, axis).name for axis in "xz"] for i in range(1, len(body.rest_mm) + 1)]
        here, there = (
            np.array([[of[name] for name in pair] for pair in names]).transpose(2, 0, 1)
            for of in ({name: body.readings[name][seen] for name in body.compared}, other)
        )
        places = carried(there, there[0], here[0] - there[0])
        other |= {
            name: places[:, i, k] for i, pair in enumerate(names) for k, name in enumerate(pair)
        }
    return np.concatenate([other[name] - body.readings[name][seen] for name in body.compared])

"""Pictures of the deformed finger at chosen pressures, without a display.

>>> drawn = draw(run / "fields.pvd", [0, 100, 200])  # doctest: +SKIP
>>> drawn.save_each(run)  # doctest: +SKIP
>>> drawn.save_strip(run / "strip.png")  # doctest: +SKIP

Under MPI these functions are for one rank (rank 0): they read all pieces from disk and do not
communicate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.interpolate import PchipInterpolator

from dolfingrip.channels import FIELDS, INSIDE, MOVED, TIME, Channel, Colour, Quantity
from dolfingrip.charts.theme import DPI, colour_map
from dolfingrip.files.table import Columns
from dolfingrip.report import video
from dolfingrip.report.beside import ALONE, Beside
from dolfingrip.report.fields import find_steps, list_steps, load_result, read_steps
from dolfingrip.report.layout import around, save_pictures, trim
from dolfingrip.report.opened import sawn
from dolfingrip.report.scene import Image, View, draw_shapes
from dolfingrip.report.skin import Floats, extract_skin, mid_plane

__all__ = ["Pictures", "Quantity", "Shown", "draw"]

Shown = Literal["whole", "half", "section"]

SIDE, CUT = View(), View(azimuth_deg=0.0, elevation_deg=0.0)

STRIP_MARGIN_PX = DPI // 12
"""White to the left and right of each picture of a strip."""


@dataclass(frozen=True)
class Pictures:
    """Deformed shapes of one finger, drawn with one camera, one scale and one range of colours.

    Attributes:
        images: one for each pressure, each of shape (height, width, 3).
        labels: text above each, e.g. ``100 kPa``.
        px_per_mm: pixels that a millimetre takes.
        view: direction of the camera; None: it turns from picture to picture.
        colour_by: quantity of the colours, or none.
        range_: values at the ends of the colour scale, in the field's unit.
        open_ended: whether values above the range occur.
    """

    images: list[Image]
    labels: list[str]
    px_per_mm: float
    view: View | None
    colour_by: Colour
    range_: tuple[float, float]
    open_ended: bool

    def save_each(self, folder: Path, stem: str = "finger") -> list[Path]:
        """Write one PNG for each pressure; all have the same frame.

        Args:
            folder: made where missing.
            stem: files are called ``<stem>_<pressure>kPa.png``.

        Returns:
            The files, in the order of the pressures.
        """
        return [
            self._save([image], [label], folder / f"{stem}_{label.replace(' ', '')}.png")
            for image, label in zip(self.images, self.labels, strict=True)
        ]

    def save_strip(self, file: Path) -> Path:
        """Write all pictures side by side into one PNG."""
        return self._save([trim(i, STRIP_MARGIN_PX) for i in self.images], self.labels, file)

    def save_video(self, stem: Path) -> list[Path]:
        """Write all pictures as a video, each with its label above it.

        Args:
            stem: path of the MP4 and of the GIF, without their suffix.

        Returns:
            The files.
        """
        empty = np.full_like(self.images[0], 255)
        drawn, place = around(empty, **self._scales)

        def around_each() -> Iterator[Image]:
            for image in self.images:
                drawn[place] = image
                yield drawn

        frames = video.titled(around_each(), self.labels, video.POLICY.large_px)
        return video.write(stem, frames)

    def _save(self, images: Sequence[Image], labels: Sequence[str], file: Path) -> Path:
        return save_pictures(images, labels, file, **self._scales)

    @property
    def _scales(self) -> dict[str, Any]:
        """The settings of the scales around the pictures."""
        return {
            "px_per_mm": self.px_per_mm, "view": self.view,
            "colour_map": colour_map(self.colour_by), "range_": self.range_,
            "scale_label": "" if self.colour_by == "none" else FIELDS[self.colour_by].label,
            "open_ended": self.open_ended,
        }  # fmt: skip


def draw(
    fields: Path,
    pressures_kPa: Sequence[float],
    *,
    colour_by: Colour = "displacement",
    shown: Shown = "whole",
    result: Columns | Path | None = None,
    branch: str = "loading",
    beside: Beside = ALONE,
    height_in: float = 4.0,
) -> Pictures:
    """Draw the deformed finger at each pressure, all with one camera and scale.

    Args:
        fields: ParaView collection whose steps are the rows of the result, in order, with point
            data ``displacement_mm`` (vector) and the arrays of ``channels.FIELDS``.
        pressures_kPa: Pressures to draw, each one a row of the result.
        colour_by: name of a field, such as ``displacement`` (magnitude, mm), or ``none``.
        shown: ``whole``: a half finger y ≥ 0 is completed by its mirror image. ``half``: it is
            drawn as it is, cut open towards the reader, and so is half of a whole one.
            ``section``: the cut y = 0 through the
            cavity alone, seen from the side; fields of a whole finger are refused.
        result: columns of the result, or its CSV file; None: ``result.csv`` in the same folder.
        branch: ``loading`` or ``unloading``, which may both have the pressure.
        beside: what else is drawn.
        height_in: height of the finger's frame in inches, at 300 dots per inch.

    Raises:
        ValueError: One line: a pressure that is not in the results (with those that are), steps and
            rows that differ in number, or fields that are missing or of the wrong kind.
    """
    if not len(pressures_kPa):
        raise ValueError("pressures_kPa = []: allowed: at least one pressure")
    table, files = _steps(fields, result)
    steps = [files[step] for step in find_steps(table, pressures_kPa, branch)]
    labels = [f"{pressure:.4g} kPa" for pressure in pressures_kPa]
    height_px = round(height_in * DPI)
    return _drawn(steps, labels, colour_by, shown=shown, beside=beside, height_px=height_px)


def draw_video(
    fields: Path,
    channels: Sequence[Channel],
    *,
    colour_by: Colour = "displacement",
    shown: Shown = "whole",
    result: Columns | Path | None = None,
    beside: Beside = ALONE,
    seconds: float | None = None,
    turn_deg: float = 0.0,
) -> Pictures:
    """Draw the deformed finger from reading to reading, with shapes between them.

    Shapes, colours and numbers between two readings are interpolated.

    Args:
        fields: ParaView collection, as that of :func:`draw`.
        channels: columns of the result that the label above each picture says.
        colour_by: quantity of the colours.
        shown: part of the finger, as that of :func:`draw`.
        result: columns of the result, or its CSV file; None: ``result.csv`` in the same folder.
        beside: what else is drawn.
        seconds: length of the video; None: ten, and the motion's own time where the finger moves in
            time.
        turn_deg: angle by which the camera turns about the vertical.

    Returns:
        As many pictures as a video of that length has.

    Raises:
        ValueError: one line, as that of :func:`draw`.
    """
    table, files = _steps(fields, result)
    time_s = np.asarray(table[TIME.name], dtype=float)
    rows = np.arange(len(time_s), dtype=float)
    over = time_s if (np.diff(time_s) > 0).all() else rows
    own_s = float(np.ptp(time_s)) if TIME in channels and over is time_s else None
    at = np.linspace(over[0], over[-1], video.POLICY.frames(seconds or own_s))

    def between(values: Sequence[Any]) -> list[Any]:
        if len(rows) == 1:
            return [values[0] for _ in at]
        return list(PchipInterpolator(over, np.array(values, dtype=float))(at))

    said = zip(*(between(table[channel.name]) for channel in channels), strict=True)
    labels = [
        ", ".join(channel.said(value) for channel, value in zip(channels, values, strict=True))
        for values in said
    ]
    if seconds and own_s and (slower := round(seconds / own_s, 1)) != 1:
        labels = [f"{label} ({slower:g} times slower)" for label in labels]
    height_px = video.POLICY.height_px
    return _drawn(
        files[: len(rows)], labels, colour_by, shown=shown, beside=beside,
        height_px=height_px, between=between, turn_deg=turn_deg,
    )  # fmt: skip


def _steps(fields: Path, result: Columns | Path | None) -> tuple[Columns, list[Path]]:
    """The columns of a result, and the files of its steps."""
    table, files = load_result(fields, result), list_steps(fields)
    rows = len(list(table["pressure_kPa"])) if "pressure_kPa" in table else len(files)
    if len(files) not in (rows, rows + 1):  # a run that was killed may have a step more
        raise ValueError(f"{fields}: {len(files)} steps, but the result has {rows} rows")
    return table, files


def _drawn(
    files: Sequence[Path],
    labels: list[str],
    colour_by: Colour,
    *,
    shown: Shown = "whole",
    beside: Beside = ALONE,
    height_px: int,
    between: Callable[[list[Floats]], list[Floats]] = list,
    turn_deg: float = 0.0,
) -> Pictures:
    """Pictures of steps, or of what ``between`` makes of their displacements and colours."""
    if colour_by not in (*FIELDS, "none"):
        raise ValueError(f"colour_by = {colour_by}: allowed: {', '.join(FIELDS)}, none")
    mesh, displacements, by_name = read_steps(files)
    by_name[MOVED.name] = [np.linalg.norm(step, axis=1) for step in displacements]
    by_name["none"] = [np.zeros(len(step)) for step in displacements]
    if colour_by not in by_name:
        raise ValueError(f"{files[0].parent}: no {colour_by}; allowed: {', '.join(by_name)}")
    values, plane = by_name[colour_by], mid_plane(mesh.points)
    if shown == "half" and mesh.points[:, 1].min() < plane:
        count = len(displacements)
        mesh, fields, _ = sawn(mesh, [*displacements, *values])
        displacements, values = fields[:count], fields[count:]
    skin = extract_skin(mesh, mirror=shown == "whole", cut=shown == "section")
    values = [value[skin.node] for value in values]
    if colour_by == INSIDE.name:
        values = [skin.on_walls(value, plane) for value in values]
    range_, open_ended = colour_range(values, colour_by)
    view = CUT if shown == "section" else SIDE
    images, px_per_mm = draw_shapes(
        skin,
        between(displacements),
        between(values),
        range_=range_,
        colour_map=colour_map(colour_by),
        view=view,
        turn_deg=turn_deg,
        height_px=height_px,
        beside=beside,
    )
    seen = None if turn_deg else view
    return Pictures(images, labels, px_per_mm, seen, colour_by, range_, open_ended)


def colour_range(values: Sequence[Floats], colour_by: Colour) -> tuple[tuple[float, float], bool]:
    """Find the ends of the colour scale of all pictures, and whether values exceed it.

    Args:
        values: at all points or triangles of each picture, in the field's unit.
        colour_by: the field, or none.
    """
    every = np.concatenate(values)
    low = FIELDS[colour_by].least if colour_by in FIELDS else 0.0
    if colour_by == INSIDE.name:  # of suction, too
        low = min(low, float(every.min()))
    highest = float(every.max())
    # Stretch and stress peak at sharp edges; a few nodes there would leave the rest in one colour.
    exact = colour_by in (MOVED.name, INSIDE.name)
    high = highest if exact else float(np.quantile(every, 0.995))
    if high - low < 1e-6:
        return (low, low + 1.0), False
    return (low, high), highest > 1.001 * high

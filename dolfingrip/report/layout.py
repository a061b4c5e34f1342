"""Lettering around pictures: pressure, scale bar, axes and colour scale, never over the finger."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure

from dolfingrip.charts.theme import DPI, INK, figure_theme, save
from dolfingrip.report.scene import Image, View

_TOP, _BOTTOM, _RIGHT, _SIDE, _LOW = 0.34, 0.66, 1.05, 0.10, 0.40
"""Strips for the label, the scale bar with axes and the colour scale, the least margin, and the
strip for the scale bar alone (inches)."""

_POINTS = 96.0
"""Size of bold letters (points) that are an inch wide, with a space beside each."""

_BAR = 0.9
"""Longest scale bar (inches)."""


def trim(picture: Image, margin_px: int) -> Image:
    """Cut empty columns off both sides and leave a margin; the height stays."""
    filled = np.flatnonzero((picture < 250).any(axis=(0, 2)))
    if filled.size == 0:
        return picture
    low, high = max(filled[0] - margin_px, 0), filled[-1] + margin_px + 1
    return picture[:, low:high]


def save_pictures(
    pictures: Sequence[Image], labels: Sequence[str], out: Path, **scales: Any
) -> Path:
    """Write pictures side by side as one PNG with one colour scale and one scale bar.

    Args:
        pictures: of shape (height, width, 3) with one height and one scale.
        labels: A short text above each, e.g. ``100 kPa``.
        out: file to write.
        scales: arguments of :func:`framed`.
    """
    with figure_theme():
        save(framed(pictures, labels, **scales), out)
    return out


def around(picture: Image, **scales: Any) -> tuple[Image, tuple[slice, slice]]:
    """Draw the colour scale, the scale bar and the axes around an empty picture.

    Args:
        picture: of shape (height, width, 3).
        scales: arguments of :func:`framed`.

    Returns:
        The whole picture without a strip for a label, and the place of ``picture`` in it.
    """
    with figure_theme():
        canvas = FigureCanvasAgg(framed([picture], [""], **scales))
        canvas.draw()
        drawn = np.array(canvas.buffer_rgba())[round(_TOP * DPI) :, :, :3]
    height, width, left = *picture.shape[:2], round(_SIDE * DPI)
    below = round((_BOTTOM if scales["view"] else _LOW) * DPI)
    top = max(len(drawn) - below - height, 0)  # a pixel may be lost to rounding
    return drawn, (slice(top, top + height), slice(left, left + width))


def framed(
    pictures: Sequence[Image],
    labels: Sequence[str],
    *,
    px_per_mm: float,
    view: View | None,
    colour_map: Colormap,
    range_: tuple[float, float],
    scale_label: str,
    open_ended: bool = False,
) -> Figure:
    """Place pictures side by side with one colour scale and one scale bar.

    Args:
        pictures: of shape (height, width, 3) with one height and one scale.
        labels: A short text above each, e.g. ``100 kPa``.
        px_per_mm: scale of the pictures; the scale bar holds for lengths in the plane of the
            picture.
        view: camera of the pictures, which the directions of the axes follow from; None: it turns,
            and no axes are drawn.
        colour_map, range_, scale_label: the colour scale, with the unit in its label; without a
            label there is none.
        open_ended: whether values above the range occur (the scale then ends in an arrow).
    """
    height = pictures[0].shape[0] / DPI
    widths = [picture.shape[1] / DPI for picture in pictures]
    bottom = _BOTTOM if view else _LOW
    right = _RIGHT if scale_label else _SIDE
    bar_mm, start = scale_bar_mm(px_per_mm), 1.0 if view else _SIDE
    widest = max(_SIDE + sum(widths), start + bar_mm * px_per_mm / DPI)
    size = (widest + right, _TOP + height + bottom)
    figure = Figure(figsize=size, dpi=DPI)
    FigureCanvasAgg(figure)
    room = min(wide / max(len(text), 1) for wide, text in zip(widths, labels, strict=True))
    place_pictures(
        figure, pictures, labels, (_SIDE, bottom), below_top_in=0.08,
        fontsize=min(11.0, _POINTS * room), fontweight="bold",
    )  # fmt: skip
    _draw_scale(figure, (start, start + bar_mm * px_per_mm / DPI), f"{bar_mm:g} mm", view, bottom)
    if not scale_label:
        return figure
    left, low = size[0] - right + 0.15, bottom + 0.15 * height
    box = (left / size[0], low / size[1], 0.14 / size[0], 0.7 * height / size[1])
    ends = "max" if open_ended else "neither"
    colours = ScalarMappable(Normalize(*range_), colour_map)
    figure.colorbar(colours, cax=figure.add_axes(box), label=scale_label, extend=ends)
    return figure


def place_pictures(
    figure: Figure,
    pictures: Sequence[Image],
    labels: Sequence[str],
    corner_in: tuple[float, float],
    gap_in: float = 0.0,
    *,
    below_top_in: float,
    **font: Any,
) -> None:
    """Place pictures side by side at their resolution, each with a label above it.

    Args:
        figure: that they are placed in.
        pictures: of equal heights.
        labels: a text for each.
        corner_in: lower left corner of the first one (inches).
        gap_in: between two of them (inches).
        below_top_in: upper end of the labels, from the figure's top (inches).
        font: size and weight of the labels.
    """
    size, (left, bottom) = figure.get_size_inches(), corner_in
    for picture, label in zip(pictures, labels, strict=True):
        height, width = (length / DPI for length in picture.shape[:2])
        box = (left / size[0], bottom / size[1], width / size[0], height / size[1])
        axes = figure.add_axes(box)
        axes.imshow(picture, interpolation="none", aspect="auto")
        axes.set_axis_off()
        middle = (left + width / 2) / size[0]
        figure.text(middle, 1 - below_top_in / size[1], label, ha="center", va="top", **font)
        left += width + gap_in


def scale_bar_mm(px_per_mm: float) -> float:
    """Length of the scale bar: 1, 2 or 5 times a power of ten, as long as there is room for.

    Args:
        px_per_mm: scale of the pictures.
    """
    most = _BAR * DPI / px_per_mm
    ten = 10.0 ** np.floor(np.log10(most))
    return float(max(digit * ten for digit in (1, 2, 5) if digit * ten <= most))


def _draw_scale(
    figure: Figure, ends: tuple[float, float], said: str, view: View | None, tall: float
) -> None:
    """A scale bar between ``ends`` (inches) and the axes' directions, below the pictures."""
    width, height = figure.get_size_inches()
    strip = figure.add_axes((0, 0, 1, tall / height))
    strip.set(xlim=(0, width), ylim=(0, tall))
    strip.set_axis_off()
    level = 0.38 if view else 0.3
    strip.plot(ends, [level, level], color=INK, lw=2.2, solid_capstyle="butt")
    strip.text(sum(ends) / 2, level - 0.06, said, ha="center", va="top")
    if view is None:
        return
    right, up, _ = view.axes
    x, y = 0.52, 0.49 if up[2] < 0 else 0.17
    for i, name in enumerate("xyz"):
        dx, dy = 0.32 * float(right[i]), 0.32 * float(up[i])
        if np.hypot(dx, dy) < 0.05:  # the axis points at the reader
            continue
        strip.annotate(
            "",
            (x + dx, y + dy),
            (x, y),
            arrowprops={
                "arrowstyle": "-|>",
                "color": INK,
                "lw": 0.9,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 6,
            },
        )
        strip.text(x + 1.3 * dx, y + 1.3 * dy, name, ha="center", va="center", fontsize=8)

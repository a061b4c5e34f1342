"""Charts as PNG files, drawn by Matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Any, Final, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dolfingrip.charts import theme
from dolfingrip.charts.chart import Axis, Chart, Mark, Series, runs
from dolfingrip.charts.theme import save

COLOURS: Final = {
    "blue": theme.BLUE, "orange": theme.ORANGE, "green": theme.GREEN, "purple": theme.PURPLE,
    "ink": theme.INK, "grey": theme.GREY, "pale": theme.PALE,
}  # fmt: skip
"""Colours by name; series without one take the first six in order."""

LINES: Final = {"line": "-", "dash": "--", "dots": ":", "points": ""}
"""Matplotlib's line style of each style."""

BRANCHES: Final[dict[str, dict[str, Any]]] = {
    "loading": {},
    "hold": {"linestyle": ":"},
    "unloading": {"linestyle": "--", "markerfacecolor": "white"},
}
"""How the branches of a line differ."""

BRANCH_MARKERS: Final = {"loading": "o", "unloading": "s", "hold": "^"}
"""Marks of measured points, by branch."""

POINTS: Final[dict[str, dict[str, Any]]] = {
    ".": {"marker": "o", "markersize": 2.5, "markeredgewidth": 0.0},
    "|": {"markersize": 9, "markeredgewidth": 1.6},
    "s": {"markersize": 6, "markeredgecolor": theme.INK, "zorder": 4.5},
    "*": {"markersize": 11, "markeredgecolor": theme.INK, "zorder": 5},
}
"""How points with these marks look."""

MANY: Final = ((300, 1.2), (80, 2.0))
"""Points of a series from which its marks are filled and this small, in points of the print."""

NOTE_LETTERS_PER_IN: Final = 17
"""Letters of a note in an inch of its panel, whose axes take a part of it."""

KEYS: Final[dict[str, dict[str, Any]]] = {
    "best": {"loc": "best"},
    "above": {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 2},
}
"""Where the key of a chart stands."""


@dataclass(frozen=True, slots=True)
class Look:
    """How charts stand in a picture.

    Attributes:
        across: charts side by side.
        panel_in: width and height of each, in inches.
        dpi: dots per inch.
        key: where keys stand; "below": one for all charts, below them.
        titled: whether each chart has its title above it.
        title: above all charts.
        name_width: characters of a line that names a bar.
        bar_share: part of a place that its bars fill.
        lower_share: height of a chart below another, by that of the upper one.
    """

    across: int = 3
    panel_in: tuple[float, float] = (6.0, 4.0)
    dpi: int = 300
    key: Literal["best", "above", "below"] = "best"
    titled: bool = False
    title: str = ""
    name_width: int = 40
    bar_share: float = 0.8
    lower_share: float = 0.5


def write(charts: Sequence[Chart], file: Path, look: Look | None = None) -> Path:
    """Write charts side by side as one PNG.

    Args:
        charts: at least one.
        file: target.
        look: sizes and the place of keys; None: the usual ones.

    Returns:
        The file.

    Raises:
        WriteError: one line, if it cannot be written.
    """
    look = look or Look()
    across = min(len(charts), look.across)
    down = -(-len(charts) // across)
    heights = [1.0, look.lower_share] if any(c.below for c in charts) else [1.0]
    stack = len(heights)
    with theme.figure_theme():
        # A Figure of its own, not pyplot's: pyplot would keep it open and choose a backend.
        figure = Figure(
            figsize=(look.panel_in[0] * across, look.panel_in[1] * down * sum(heights)),
            layout="constrained",
        )
        FigureCanvasAgg(figure)
        panels = figure.subplots(down * stack, across, squeeze=False, height_ratios=heights * down)
        for axes in panels.flat:
            axes.set_axis_off()  # of those that stay empty
        for number, chart in enumerate(charts):
            upper, *lower = panels[stack * (number // across) :, number % across][:stack]
            draw(chart, upper, look)
            if chart.below is not None:
                draw(chart.below, lower[0], look)
                lower[0].sharex(upper)
                upper.set_xlabel("")
                upper.tick_params(labelbottom=False)
        if look.key == "below":
            shown = [panel.get_legend_handles_labels() for panel in figure.axes]
            keys = {key: handle for pair in shown for handle, key in zip(*pair, strict=True)}
            handles = list(keys.values())
            figure.legend(handles, list(keys), loc="outside lower center", ncols=min(5, 2 * across))
        if look.title:
            figure.suptitle(look.title, fontsize=9)
        save(figure, file, look.dpi)
    return file


def draw(chart: Chart, axes: Axes, look: Look | None = None) -> None:
    """Draw a chart into axes of Matplotlib.

    Args:
        chart: what is drawn.
        axes: empty axes, or those of another chart, whose colours are left to it.
        look: where the key stands, and whether the title is drawn; None: the usual look.
    """
    look = look or Look()
    axes.set_axis_on()
    there = {line.get_color() for line in axes.get_lines()}
    taken = {s.colour for s in chart.series} | {n for n, code in COLOURS.items() if code in there}
    free = iter(([name for name in COLOURS if name not in taken] or list(COLOURS)) * 9)
    colour = theme.INK
    bars = [bar for bar in chart.series if bar.style == "bar"]
    for series in chart.series:
        if series.colour or series.name:
            colour = COLOURS[series.colour or next(free)]
        if series.style == "bar":
            _draw_bars(axes, series, bars, colour, look)
        else:
            _draw_series(axes, series, colour)
    for mark in chart.marks:
        _draw_mark(axes, mark)
    _set_axis(axes, "x", chart.x, look)
    _set_axis(axes, "y", chart.y, look)
    if chart.equal:
        axes.set_aspect("equal", adjustable="datalim")
    note = fill(chart.note, round(NOTE_LETTERS_PER_IN * look.panel_in[0]))
    if look.titled:
        pad = 7 + 8 * (note.count("\n") + 1) if note else None
        axes.set_title(chart.title, fontsize=9, pad=pad)
    if note:
        axes.annotate(
            note, (0.0, 1.0), xycoords="axes fraction", xytext=(0, 2),
            textcoords="offset points", va="bottom", fontsize=6.5, color=theme.GREY,
        )  # fmt: skip
    if look.key != "below" and axes.get_legend_handles_labels()[1]:
        axes.legend(**KEYS[look.key], fontsize=8 if look.across == 1 else 7)


def _draw_mark(axes: Axes, mark: Mark) -> None:
    across = mark.axis == "x"
    colour, key = COLOURS[mark.colour], None if mark.beside else mark.label or None
    if mark.to is not None:
        span = axes.axvspan if across else axes.axhspan
        span(mark.at, mark.to, color=colour, alpha=0.5, lw=0, label=key)
        return
    line = axes.axvline if across else axes.axhline
    style = "-" if not mark.label else ":" if mark.beside else "-."
    line(mark.at, color=colour, lw=0.8, ls=style, zorder=1, label=key)
    if mark.beside:  # along the line, so that labels of close lines do not overlap
        axes.annotate(
            mark.label, (mark.at, 1.0) if across else (1.0, mark.at),
            xycoords=("data", "axes fraction") if across else ("axes fraction", "data"),
            xytext=(-2, -2 if across else 2), textcoords="offset points",
            rotation="vertical" if across else "horizontal", ha="right",
            va="top" if across else "bottom", color=colour, fontsize=8,
        )  # fmt: skip


def _draw_series(axes: Axes, series: Series, colour: str) -> None:
    x, y = np.asarray(series.x, dtype=float), np.asarray(series.y, dtype=float)
    points = series.style == "points"
    if series.low is not None and series.high is not None:
        low, high = np.asarray(series.low), np.asarray(series.high)
        if points:
            axes.vlines(x, low, high, color=colour, lw=0.7, zorder=3.5)
        else:  # not translucent: where bands overlap they would be darker
            axes.fill_between(x, low, high, color=theme.tint(colour), lw=0, zorder=1)
    marker = series.marker or ("o" if points or series.branches is not None else "")
    style: dict[str, Any] = {"marker": marker, "color": colour, "linestyle": LINES[series.style]}
    style["zorder"] = 4 if points else 3
    if series.style in ("dash", "dots") or series.colour == "grey":
        style["linewidth"] = 1.2
    if points:
        style |= {"markerfacecolor": "none", "markeredgewidth": 0.8, "clip_on": False}
        style |= POINTS.get(marker, {"markersize": 3.5} if series.branches is not None else {})
        if marker in ("*", "s", "."):
            style["markerfacecolor"] = colour
        elif small := next((size for count, size in MANY if x.size > count), None):
            style |= {"markersize": small, "markerfacecolor": colour, "markeredgewidth": 0.0}
    if series.branches is None:
        axes.plot(x, y, label=series.name or None, **style)
        return
    branches = np.asarray(series.branches)
    present = list(dict.fromkeys(branches.tolist()))
    for branch in present:
        branch_style = {**style, "clip_on": False}
        if points:
            branch_style["marker"] = BRANCH_MARKERS.get(branch, "o")
        else:
            branch_style |= BRANCHES.get(branch, {})
        label = series.name if len(present) == 1 else f"{series.name}, {branch}"
        for number, rows in enumerate(runs(branches == branch)):
            # a line begins at the turn, or the curve would have a gap
            first = rows.start if points else max(rows.start - 1, 0)
            axes.plot(
                x[first : rows.stop], y[first : rows.stop], label=None if number else label,
                markevery=slice(rows.start - first, None), **branch_style,
            )  # fmt: skip


def _draw_bars(axes: Axes, series: Series, bars: Sequence[Series], colour: str, look: Look) -> None:
    """Draw bars to the right; those of one place stand below one another."""
    length, place = np.asarray(series.x, dtype=float), np.asarray(series.y, dtype=float)
    stack = [id(bar) for bar in bars if np.intersect1d(bar.y, place).size] or [id(series)]
    height = look.bar_share / len(stack)
    place = place + height * (stack.index(id(series)) - (len(stack) - 1) / 2)
    axes.barh(place, length, height, color=colour, label=series.name or None)
    if series.low is not None and series.high is not None:
        axes.hlines(place, series.low, series.high, color=theme.INK, lw=1.0)
    for text, at, end in zip(series.said, place, length, strict=False):
        axes.annotate(
            text, (end, at), xytext=(4, 0), textcoords="offset points", va="center", fontsize=7
        )


def _set_axis(axes: Axes, name: Literal["x", "y"], axis: Axis, look: Look) -> None:
    side = axes.xaxis if name == "x" else axes.yaxis
    side.set_label_text(axis.label)
    set_ends = axes.set_xlim if name == "x" else axes.set_ylim
    if axis.log:
        (axes.set_xscale if name == "x" else axes.set_yscale)("log")
    if axis.whole:
        side.set_major_locator(MaxNLocator(integer=True))
    if axis.names:
        side.set_ticks(range(len(axis.names)), [fill(n, look.name_width) for n in axis.names])
        side.set_tick_params(labelsize=7)
        side.grid(visible=False)
        set_ends(len(axis.names) - 0.4, -0.6)
    elif axis.ends is not None:
        set_ends(*axis.ends)
    elif axis.zero:
        low, width = (
            getattr(axes.dataLim, f"{name}0"),
            getattr(axes.dataLim, {"x": "width", "y": "height"}[name]),
        )
        if low >= -0.01 * width:
            set_ends(0.0)

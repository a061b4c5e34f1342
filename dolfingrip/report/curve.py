"""Curves of an experiment's result, such as an angle against pressure."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.channels import TIME
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.report.columns import Columns, branches, numbers, required, select_rows
from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PALE, PURPLE, figure_theme, save

SIZE_IN = (6.0, 4.0)

_LINES = ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^"), (PURPLE, "v"))
"""Colour and marker of a plot's first, second and further curves."""

_STYLES: dict[str, dict[str, Any]] = {
    "loading": {"linestyle": "-"},
    "hold": {"linestyle": ":"},
    "unloading": {"linestyle": "--", "markerfacecolor": "white"},
}


class TurningPoint(Protocol):
    """The point at which the blocked force begins to rise faster; two straight lines meet there."""

    @property
    def pressure_kPa(self) -> float: ...

    @property
    def force_N(self) -> float: ...

    @property
    def slope_before_N_per_kPa(self) -> float: ...

    @property
    def slope_after_N_per_kPa(self) -> float: ...


def plot(
    experiment: Experiment,
    result: Columns,
    path: Path,
    turning_point: TurningPoint | None = None,
    *,
    measured: Columns | None = None,
) -> Path:
    """Draw a result as the experiment's ``plot`` says.

    Args:
        experiment: whose result it is.
        result: columns that ``experiment.plot`` names; the first of its curves must be there. A
            column ``branch`` distinguishes loading from unloading.
        path: PNG to write (6 in × 4 in).
        turning_point: pressure (kPa), force (N) and the slopes (N/kPa) of the lines that meet
            there.
        measured: measurements of the first curve, drawn as points. If it has a column
            ``experiment``, only the rows of this experiment are drawn.

    Raises:
        ValueError: One line naming a column that is missing.
    """
    plot_of = experiment.plot
    with _axes(path, plot_of.label, plot_of.over.label) as axes:
        for i, (curve, (colour, marker)) in enumerate(zip(plot_of.curves, _LINES, strict=False)):
            if i == 0 or numbers(result, curve.column) is not None:
                _draw(axes, result, curve.column, curve.label, colour, marker, plot_of.over.name)
        if plot_of.over == TIME:
            _mark_lift(axes, required(result, TIME.name), branches(result))
        if measured is not None:
            _draw_measured(axes, measured, experiment)
        if turning_point is not None:
            over = required(result, plot_of.over.name)
            _draw_turning_point(axes, turning_point, np.nanmin(over), np.nanmax(over))
    return path


@contextmanager
def _axes(path: Path, label: str, over: str) -> Iterator[Axes]:
    """Axes whose abscissa is labelled ``over``; saved on leaving, with limits around the origin."""
    with figure_theme():
        # A Figure of its own, not pyplot's: pyplot would keep it open and choose a backend.
        figure = Figure(figsize=SIZE_IN, layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.set(xlabel=over, ylabel=label)
        yield axes
        # The axes begin at the origin, unless readings lie below it by more than noise.
        if axes.dataLim.x0 >= -0.01 * axes.dataLim.width:
            axes.set_xlim(left=0.0)
        if axes.dataLim.y0 >= -0.01 * axes.dataLim.height:
            axes.set_ylim(bottom=0.0)
        axes.legend(loc="best")
        save(figure, path)


def _draw(
    axes: Axes,
    result: Columns,
    name: str,
    label: str,
    colour: str,
    marker: str,
    over: str,
) -> None:
    """Draw one column, a line for each branch; the lines join where the load turns."""
    along, values = required(result, over), required(result, name)
    # over time branches follow one another, so that a curve needs no mark of them
    branch = branches(result) if over != TIME.name else np.full(len(along), "loading")
    present = list(dict.fromkeys(branch))
    for kind in present:
        style = {"marker": marker, "color": colour, **_STYLES.get(kind, {})}
        text = label if len(present) == 1 else f"{label}, {kind}"
        for number, rows in enumerate(_runs(branch == kind)):
            first = max(rows.start - 1, 0)  # from the turn on, or the curve would have a gap
            part = slice(first, rows.stop)
            axes.plot(
                along[part],
                values[part],
                label=text if number == 0 else None,
                markevery=slice(rows.start - first, None),
                clip_on=False,
                zorder=3,
                **style,
            )


def _mark_lift(axes: Axes, time_s: Any, branch: Any) -> None:
    """Shade the time of a grasp's lift."""
    for rows in _runs(branch == "lift"):
        start = time_s[max(rows.start - 1, 0)]
        axes.axvspan(start, time_s[rows.stop - 1], color=PALE, alpha=0.5, lw=0, label="lift")


def _runs(mask: Any) -> list[slice]:
    """Slices of consecutive True values."""
    steps = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [slice(int(a), int(b)) for a, b in zip(steps[::2], steps[1::2], strict=True)]


def _draw_measured(axes: Axes, measured: Columns, experiment: Experiment) -> None:
    table = select_rows(measured, "experiment", experiment.name)
    plot_of = experiment.plot
    axes.plot(
        required(table, plot_of.over.name),
        required(table, plot_of.curves[0].column),
        "D",
        color=INK,
        label="measured",
        markerfacecolor="none",
        markersize=5,
        clip_on=False,
        zorder=4,
    )


def _draw_turning_point(axes: Axes, turn: TurningPoint, lowest: float, highest: float) -> None:
    """Draw both fitted lines, each a little beyond where they meet, and the pressure there."""
    overlap = 0.12 * (highest - lowest)
    slopes = (
        ("before", turn.slope_before_N_per_kPa, lowest, min(turn.pressure_kPa + overlap, highest)),
        ("after", turn.slope_after_N_per_kPa, max(turn.pressure_kPa - overlap, lowest), highest),
    )
    limits = axes.get_ylim()
    for (side, slope, start, stop), colour in zip(slopes, (GREEN, PURPLE), strict=True):
        at = np.array([start, stop])
        axes.plot(
            at,
            turn.force_N + slope * (at - turn.pressure_kPa),
            "--",
            color=colour,
            lw=1.4,
            label=f"fit {side}: {slope:.4f} N/kPa",
            zorder=3.5,
        )
    axes.axvline(
        turn.pressure_kPa,
        color=GREY,
        lw=1.0,
        ls="-.",
        label=f"turning point: {turn.pressure_kPa:.0f} kPa, {turn.force_N:.2f} N",
    )
    axes.plot([turn.pressure_kPa], [turn.force_N], "o", ms=9, mfc="none", mec=GREY, mew=1.2)
    axes.set_ylim(limits)

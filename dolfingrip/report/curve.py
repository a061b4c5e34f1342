"""Curves against pressure: bending angle (the paper's Fig. 3) and blocked force (its Fig. 4)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.report.columns import Columns, branches, numbers, required, select_rows
from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, figure_theme

SIZE_IN = (6.0, 4.0)

_STYLES: dict[str, dict[str, Any]] = {
    "loading": {"linestyle": "-"},
    "hold": {"linestyle": ":"},
    "unloading": {"linestyle": "--", "markerfacecolor": "white"},
}


class TurningPoint(Protocol):
    """Where the blocked force begins to rise faster, by two straight lines that meet there."""

    @property
    def pressure_kPa(self) -> float: ...

    @property
    def force_N(self) -> float: ...

    @property
    def slope_before_N_per_kPa(self) -> float: ...

    @property
    def slope_after_N_per_kPa(self) -> float: ...


def plot_bending(result: Columns, path: Path, *, measured: Columns | None = None) -> Path:
    """Draw bending angles against pressure.

    Args:
        result: Columns ``pressure_kPa`` and ``angle_deg`` (tip face); drawn where present:
            ``chord_angle_deg``, and ``branch`` to tell loading from unloading.
        path: PNG to write (6 in × 4 in).
        measured: Columns ``pressure_kPa`` and ``angle_deg`` of measurements, drawn as points; with
            a column ``experiment`` only its rows ``bending``.

    Raises:
        ValueError: One line naming a column that is missing.
    """
    with _axes(path, "Bending angle (°)") as axes:
        _draw(axes, result, "angle_deg", "tip face", BLUE, "o")
        if numbers(result, "chord_angle_deg") is not None:
            _draw(axes, result, "chord_angle_deg", "chord, clamp to tip", ORANGE, "s")
        if measured is not None:
            _draw_measured(axes, measured, "bending", "angle_deg")
    return path


def plot_blocked_force(
    result: Columns,
    path: Path,
    turning_point: TurningPoint | None = None,
    *,
    measured: Columns | None = None,
) -> Path:
    """Draw the blocked force against pressure, with its turning point.

    Args:
        result: Columns ``pressure_kPa`` and ``force_N``, and ``branch`` where it is known.
        path: PNG to write (6 in × 4 in).
        turning_point: Pressure (kPa), force (N) and the slopes (N/kPa) of the lines that meet
            there.
        measured: Columns ``pressure_kPa`` and ``force_N`` of measurements, drawn as points; with a
            column ``experiment`` only its rows ``blocked_force``.

    Raises:
        ValueError: One line naming a column that is missing.
    """
    with _axes(path, "Blocked force (N)") as axes:
        _draw(axes, result, "force_N", "simulation", BLUE, "o")
        if measured is not None:
            _draw_measured(axes, measured, "blocked_force", "force_N")
        if turning_point is not None:
            pressure = required(result, "pressure_kPa")
            _draw_turning_point(axes, turning_point, np.nanmin(pressure), np.nanmax(pressure))
    return path


def plot_coupon(result: Columns, path: Path) -> Path:
    """Draw nominal stress against nominal strain.

    Args:
        result: Columns ``nominal_strain`` (–) and ``nominal_stress_MPa``, and ``branch`` where
            known.
        path: PNG to write (6 in × 4 in).

    Raises:
        ValueError: One line naming a column that is missing.
    """
    with _axes(path, "Nominal stress (MPa)", "Nominal strain (–)") as axes:
        _draw(axes, result, "nominal_stress_MPa", "simulation", BLUE, "o", over="nominal_strain")
    return path


@contextmanager
def _axes(path: Path, label: str, over: str = "Pressure (kPa)") -> Iterator[Axes]:
    """Axes over pressure or ``over``; saved on leaving, with limits that include the origin."""
    with figure_theme():
        # A figure of its own rather than pyplot's: nothing is left open, no backend is chosen.
        figure = Figure(figsize=SIZE_IN, layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.set(xlabel=over, ylabel=label)
        yield axes
        # From the origin on, but for readings truly below it (more than a fit's or sensor's noise).
        if axes.dataLim.x0 >= -0.01 * axes.dataLim.width:
            axes.set_xlim(left=0.0)
        if axes.dataLim.y0 >= -0.01 * axes.dataLim.height:
            axes.set_ylim(bottom=0.0)
        axes.legend(loc="best")
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path)


def _draw(
    axes: Axes,
    result: Columns,
    name: str,
    label: str,
    colour: str,
    marker: str,
    over: str = "pressure_kPa",
) -> None:
    """One column, a line for each branch; lines of branches join where the branch turns."""
    pressure, values = required(result, over), required(result, name)
    branch = branches(result)
    present = list(dict.fromkeys(branch))
    for kind in present:
        style = {"marker": marker, "color": colour, **_STYLES.get(kind, {})}
        text = label if len(present) == 1 else f"{label}, {kind}"
        for number, rows in enumerate(_runs(branch == kind)):
            first = max(rows.start - 1, 0)  # from the turn on, or the curve would have a gap
            part = slice(first, rows.stop)
            axes.plot(
                pressure[part],
                values[part],
                label=text if number == 0 else None,
                markevery=slice(rows.start - first, None),
                clip_on=False,
                zorder=3,
                **style,
            )


def _runs(mask: Any) -> list[slice]:
    """Stretches of consecutive True."""
    steps = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [slice(int(a), int(b)) for a, b in zip(steps[::2], steps[1::2], strict=True)]


def _draw_measured(axes: Axes, measured: Columns, experiment: str, name: str) -> None:
    table = select_rows(measured, "experiment", experiment)
    axes.plot(
        required(table, "pressure_kPa"),
        required(table, name),
        "D",
        color=INK,
        label="measured",
        markerfacecolor="none",
        markersize=5,
        clip_on=False,
        zorder=4,
    )


def _draw_turning_point(axes: Axes, turn: TurningPoint, lowest: float, highest: float) -> None:
    """Both fitted lines, each a little beyond the other's reach, and the pressure they meet at."""
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

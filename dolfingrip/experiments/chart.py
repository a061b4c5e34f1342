"""Charts of results: the curves of an experiment's plot, and its other readings by unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.channels import AIR_SUPPLY, CHANNELS, ENERGIES, PRESSURE, TIME, Channel, of_band
from dolfingrip.charts.chart import Axis, Chart, Mark, Series, Style, runs
from dolfingrip.experiments import ring_down
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.files.run import TurningPoint
from dolfingrip.files.table import Columns, branches, numbers, required, select_rows

IN_TIME: Final = (*AIR_SUPPLY, *ENERGIES)
"""Readings of a result that is in motion or has a supply."""

BAND_STD: Final = 2.0
"""Half width of a measurement's noise band, in standard deviations."""

SMALL: Final = 0.1
"""Change of a reading, by an ordinary instrument's noise, below which it counts as none."""

MOST_SERIES: Final = 8
"""Curves of one chart; more cannot be told apart."""

MARKERS: Final = "os^v"
"""Marks of a plot's first, second and further curves."""

BANDS: Final = "Bands: 95 % of what may be, by what is not known exactly of the finger and its rig."
"""Note of a chart with bands of simulations."""

BEYOND: Final = 0.12
"""Part of the pressures by which a fitted line goes on beyond a turning point."""


@dataclass(frozen=True, slots=True)
class Panel:
    """The readings of one chart.

    Attributes:
        title: of the chart.
        label: of its vertical axis, with the unit.
        curves: channels, and what the key calls them.
    """

    title: str
    label: str
    curves: Sequence[tuple[Channel, str]]


@dataclass(frozen=True, slots=True)
class DrawnResult:
    """A result as curves of a chart.

    Attributes:
        table: its columns.
        name: what the key calls it, if several results share the chart.
        style: of its curves.
        scene: number of the scene whose steps its rows are, if they are.
    """

    table: Columns
    name: str = ""
    style: Style = "line"
    scene: int | None = None


def panels(experiment: Experiment, table: Columns) -> list[Panel]:
    """List the charts of an experiment's results.

    Args:
        experiment: whose plot and table say what is shown.
        table: columns of a result, of which those of a supply are shown, too.

    Returns:
        The panel of its plot, then one for each unit of the other readings in its table.
    """
    along = over(experiment, table)
    supply = [c for c in AIR_SUPPLY if numbers(table, c.name) is not None and c.unit]
    plot = experiment.plot
    shown = {curve.column for curve in plot.curves}
    curves = [(_channel(curve.column), curve.label) for curve in plot.curves]
    listed = [Panel(experiment.title, plot.label, curves)]
    by_unit: dict[str, list[tuple[Channel, str]]] = {}
    for channel in (*experiment.table, *supply):
        driven = along == TIME or channel != experiment.control
        if driven and channel.name not in shown | {TIME.name, along.name}:
            readings = by_unit.setdefault(channel.symbol, [])
            readings.append((channel, channel.short or channel.title))
    for symbol, channels in by_unit.items():
        names = ", ".join(name for _, name in channels)
        label = channels[0][0].label if len(channels) == 1 else f"{names} ({symbol})"
        listed.append(Panel(f"{experiment.title}: {names.lower()}", label, channels))
    return listed


def over(experiment: Experiment, table: Columns) -> Channel:
    """The channel of the horizontal axis.

    Args:
        experiment: whose plot is drawn.
        table: columns of the result.

    Returns:
        The time of a result in motion or with a supply; else that of the experiment's plot, or the
        pressure if the result lacks it.
    """
    if any(numbers(table, channel.name) is not None for channel in IN_TIME):
        return TIME
    along = experiment.plot.over
    return along if numbers(table, along.name) is not None else PRESSURE


def chart(
    experiment: Experiment,
    results: Sequence[DrawnResult],
    panel: Panel | None = None,
    *,
    measured: Columns | None = None,
    turning_point: TurningPoint | None = None,
) -> Chart:
    """Make the chart of results of one experiment.

    Args:
        experiment: whose results they are.
        results: at least one.
        panel: what is shown; None: the experiment's plot.
        measured: readings of an instrument; the rows of this experiment are drawn.
        turning_point: of the first result's blocked force.

    Returns:
        A chart with a curve for each reading and result.

    Raises:
        ValueError: one line that names a column which no result has.
    """
    panel = panel or panels(experiment, results[0].table)[0]
    along = over(experiment, results[0].table)
    series: list[Series] = []
    for result in results:
        x = required(result.table, along.name)
        # over time branches follow one another, so that a curve needs no mark of them
        branch = None if along == TIME else [str(stage) for stage in branches(result.table)]
        for (channel, name), marker in zip(panel.curves, MARKERS * 9, strict=False):
            y = numbers(result.table, channel.name)
            if y is not None and len(series) < MOST_SERIES:
                if result.name:
                    name = result.name if len(panel.curves) == 1 else f"{result.name}: {name}"
                low, high = (numbers(result.table, end) for end in of_band(channel.name))
                series.append(
                    Series(name, x, y, result.style, result.scene, low, high, branch, marker=marker)
                )
    first = panel.curves[0][0]
    if not series:
        raise ValueError(f"results have no column {first.name}")
    marks = _lifts(results[0].table) if along == TIME else []
    if measured is not None:
        series += _measured(measured, experiment.name, along.name, panel.curves)
    ends = _ends(series, first)
    alone = len(results) == 1 and first.name == experiment.plot.curves[0].column
    if along == TIME and alone and (swing := _swing(experiment, results[0].table)):
        series += _envelope(swing, required(results[0].table, TIME.name))
    if turning_point is not None and along == PRESSURE:
        added, mark = _turning_point(turning_point, required(results[0].table, along.name))
        series += added
        marks.append(mark)
    return Chart(
        panel.title,
        Axis(along.label, along.symbol, zero=True),
        Axis(panel.label, first.symbol, ends=ends, zero=True),
        series,
        marks,
        BANDS if any(drawn.low is not None and drawn.marker != "D" for drawn in series) else "",
    )


def spectrum(
    experiment: Experiment, results: Sequence[DrawnResult], measured: Columns | None = None
) -> Chart | None:
    """Make the chart of a ring-down's frequencies.

    Args:
        experiment: whose first curve is taken apart.
        results: at least one.
        measured: readings of an instrument, as those of :func:`chart`.

    Returns:
        The size of the swings by their frequency, after the last change of what drives the body;
        None where no result swings.
    """
    channel = _channel(experiment.plot.curves[0].column)
    tables = [(result.table, result.name or "simulated", result.style) for result in results]
    if measured is not None:
        tables.append((select_rows(measured, "experiment", experiment.name), "measured", "dots"))
    series, notes = [], []
    for table, name, style in tables:
        if swing := _swing(experiment, table):
            time_s, y = required(table, TIME.name), required(table, channel.name)
            rows = time_s >= swing.start_s
            series.append(Series(name, *ring_down.spectrum(time_s[rows], y[rows]), style))
            notes.append(f"{name}: {swing.sentence}")
    if not series:
        return None
    return Chart(
        f"{experiment.title}: frequencies of the swing",
        Axis("Frequency (Hz)", "Hz", zero=True),
        Axis(f"Size of the swing ({channel.symbol})", channel.symbol, zero=True),
        series,
        note="; ".join(notes) + ".",
    )


def _swing(experiment: Experiment, table: Columns) -> ring_down.RingDown | None:
    """The free swing of an experiment's first curve in a table of readings in time."""
    columns = TIME.name, experiment.control.name, experiment.plot.curves[0].column
    read = [numbers(table, name) for name in columns]
    if any(values is None or not np.isfinite(values).all() for values in read):
        return None
    time_s, control, y = (values for values in read if values is not None)
    return ring_down.fit(time_s, control, y) if (np.diff(time_s) > 0).all() else None


def _envelope(swing: ring_down.RingDown, time_s: np.ndarray) -> list[Series]:
    """Both lines between which a reading swings."""
    after = time_s[(time_s >= swing.start_s) & (time_s <= swing.end_s)]
    lines = zip((f"envelope: {swing.sentence}", ""), swing.envelope(after), strict=True)
    return [Series(label, after, line, "dash", colour="grey") for label, line in lines]


def _channel(name: str) -> Channel:
    if name in CHANNELS:
        return CHANNELS[name]
    words, _, unit = name.rpartition("_")
    return Channel(name=name, unit=unit, title=words.replace("_", " "))


def _ends(series: Sequence[Series], channel: Channel) -> tuple[float, float] | None:
    """Ends of the axis of readings that hardly change, so that round-off is not blown up."""
    values = np.concatenate([np.asarray(curve.y, dtype=float) for curve in series])
    low, high = np.nanmin(values), np.nanmax(values)
    if not channel.noise or high - low >= SMALL * channel.noise:
        return None
    middle = round((low + high) / 2, 6)
    return middle - channel.noise, middle + channel.noise


def _lifts(table: Columns) -> list[Mark]:
    """Spans of the time of a grasp's lift."""
    time_s = required(table, TIME.name)
    return [
        Mark(time_s[max(rows.start - 1, 0)], "lift", "x", time_s[rows.stop - 1], "pale")
        for rows in runs(branches(table) == "lift")
    ]


def _measured(
    table: Columns, experiment: str, along: str, curves: Sequence[tuple[Channel, str]]
) -> list[Series]:
    """The readings of an instrument, with bars of its ordinary noise."""
    rows = select_rows(table, "experiment", experiment)
    x = numbers(rows, along)
    readings = [(c, name, y) for c, name in curves if (y := numbers(rows, c.name)) is not None]
    drawn = []
    if x is None:
        return []
    order = np.argsort(x, kind="stable")
    for channel, name, y in readings:
        half = BAND_STD * channel.noise
        name = "measured" if len(readings) == 1 else f"measured, {name}"
        y = y[order]
        low, high = (y - half, y + half) if half else (None, None)
        drawn.append(Series(name, x[order], y, "points", None, low, high, colour="ink", marker="D"))
    return drawn


def _turning_point(turn: TurningPoint, over: np.ndarray) -> tuple[list[Series], Mark]:
    """Both fitted lines, each a little beyond the point where they meet, and the pressure there."""
    at, force = turn.pressure_kPa, turn.force_N
    low, high = float(np.nanmin(over)), float(np.nanmax(over))
    overlap = BEYOND * (high - low)
    before, after = turn.slope_before_N_per_kPa, turn.slope_after_N_per_kPa
    lines = [("before", before, [low, min(at + overlap, high)], "green"),
             ("after", after, [max(at - overlap, low), high], "purple")]  # fmt: skip
    series = [
        Series(f"fit {side}: {slope:.4f} N/kPa", ends, [force + slope * (end - at) for end in ends],
               "dash", colour=colour)
        for side, slope, ends, colour in lines
    ]  # fmt: skip
    series.append(Series("", [at], [force], "points", colour="grey"))
    return series, Mark(at, f"turning point: {at:.0f} kPa, {force:.2f} N", "x", colour="grey")

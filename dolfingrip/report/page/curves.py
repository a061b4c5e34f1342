"""Charts of runs: results of one experiment share their charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from dolfingrip.channels import CHANNELS, TIME, Channel
from dolfingrip.report.columns import Columns, numbers, select_rows
from dolfingrip.report.page.content import Axis, Chart, Series, Style, Table
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.runs import Run, over

BAND_STD: Final = 2.0
"""Half width of a measurement's noise band, in standard deviations."""

SMALL: Final = 0.1
"""Change of a reading, by an ordinary instrument's noise, below which it counts as none."""

MOST_SERIES: Final = 8
"""Curves of one chart; more cannot be told apart."""


def charts(
    runs: Sequence[Run],
    measured: Columns | None,
    scenes: dict[int, int],
    finer: dict[int, int],
) -> list[Chart]:
    """The charts of all runs, experiment by experiment.

    Args:
        runs: with different titles.
        measured: readings of an instrument; those of a chart's experiment and channel are in it.
        scenes: number of the scene of each run that has one, by the run's place.
        finer: for a run on a coarse mesh, the place of the one on the finest mesh.
    """
    found = []
    for name in dict.fromkeys(run.experiment.name for run in runs):
        group = [i for i, run in enumerate(runs) if run.experiment.name == name]
        first = runs[group[0]]
        for title, label, channels in _panels(first):
            found.append(_chart(runs, group, title, label, channels, measured, scenes, finer))
    return [chart for chart in found if chart is not None]


def _panels(run: Run) -> list[tuple[str, str, list[tuple[Channel, str]]]]:
    """Title, label and channels of each chart: the experiment's plot, then other readings by unit.

    Of a reading that the plot has, no other chart is made.
    """
    plot = run.experiment.plot
    shown = {curve.column for curve in plot.curves}
    main = [(_channel(curve.column), curve.label) for curve in plot.curves]
    found = [(run.experiment.title, plot.label, main)]
    by_unit: dict[str, list[tuple[Channel, str]]] = {}
    for channel in run.experiment.table:
        if channel.name in shown | {TIME.name, run.experiment.control.name, over(run)}:
            continue
        by_unit.setdefault(channel.symbol, []).append((channel, channel.short or channel.title))
    for symbol, channels in by_unit.items():
        names = ", ".join(name for _, name in channels)
        label = channels[0][0].label if len(channels) == 1 else f"{names} ({symbol})"
        found.append((f"{run.experiment.title}: {names.lower()}", label, channels))
    return found


def _channel(name: str) -> Channel:
    if name in CHANNELS:
        return CHANNELS[name]
    unit = name.rpartition("_")[2]
    return Channel(name=name, unit=unit, title=name.rpartition("_")[0].replace("_", " "))


def _chart(
    runs: Sequence[Run],
    group: Sequence[int],
    title: str,
    label: str,
    channels: Sequence[tuple[Channel, str]],
    measured: Columns | None,
    scenes: dict[int, int],
    finer: dict[int, int],
) -> Chart | None:
    along = over(runs[group[0]])
    series: list[Series] = []
    columns: list[tuple[str, np.ndarray, np.ndarray]] = []
    for place in group:
        run = runs[place]
        x = run.column(along)
        for channel, name in channels:
            y = run.column(channel.name)
            if x is None or y is None or len(series) >= MOST_SERIES:
                continue
            whose = f"{run.title.partition(', ')[2]}: {name}" if len(group) > 1 else name
            if place in finer.values():
                whose += " (finest mesh)"
            style: Style = "dash" if place in finer.values() else "line"
            series.append(Series(whose, x, y, style, scenes.get(place)))
            columns.append((whose, x, y))
    if not series:
        return None
    if measured is not None:
        series += _measured(measured, runs[group[0]].experiment.name, along, channels)
    axis = _channel(along)
    symbol = channels[0][0].symbol
    alt = f"{title}: {label} over {axis.label}. The table below has the numbers."
    return Chart(
        title, alt, Axis(axis.label, axis.symbol),
        Axis(label, symbol, ends=_ends(series, channels[0][0])), series,
        _table(axis.label, columns, symbol),
    )  # fmt: skip


def _ends(series: Sequence[Series], channel: Channel) -> tuple[float, float] | None:
    """Ends of the axis of readings that hardly change, so that round-off is not blown up."""
    values = np.concatenate([np.asarray(each.y, dtype=float) for each in series])
    low, high = np.nanmin(values), np.nanmax(values)
    if high - low >= SMALL * channel.noise:
        return None
    middle = round((low + high) / 2, 6)
    return middle - channel.noise, middle + channel.noise


def _measured(
    table: Columns, experiment: str, along: str, channels: Sequence[tuple[Channel, str]]
) -> list[Series]:
    """The readings of an instrument, with a band of its ordinary noise."""
    own = select_rows(table, "experiment", experiment)
    x = numbers(own, along)
    found = []
    for channel, name in channels:
        y = numbers(own, channel.name)
        if x is None or y is None or len(y) == 0:
            continue
        order = np.argsort(x, kind="stable")
        half = BAND_STD * channel.noise
        found.append(
            Series(f"measured, {name}", x[order], y[order], "points", None,
                   y[order] - half, y[order] + half)
        )  # fmt: skip
    return found


def _table(axis: str, columns: Sequence[tuple[str, np.ndarray, np.ndarray]], symbol: str) -> Table:
    """The numbers of a chart; a curve over values of its own has a column of them."""
    first = columns[0][1]
    headings, cells = [axis], [[said(v) for v in first]]
    for name, x, y in columns:
        if len(x) != len(first) or not np.allclose(x, first, equal_nan=True):
            headings.append(axis)
            cells.append([said(v) for v in x])
        headings.append(f"{name} ({symbol})")
        cells.append([said(v) for v in y])
    length = max(len(column) for column in cells)
    rows = [[column[i] if i < len(column) else "" for column in cells] for i in range(length)]
    return Table(headings, rows)

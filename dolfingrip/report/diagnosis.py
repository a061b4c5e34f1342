"""Charts of a diagnosis: readings, simulation and residuals, probabilities, before and after."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.channels import CHANNELS, DISPLACEMENT, PRESSURE, Channel
from dolfingrip.charts.chart import Axis, Chart, Colour, Mark, Series, Style
from dolfingrip.charts.picture import Look, write
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.files.diagnosis_words import LEAST, beside_causes, chance

LEAST_PROBABILITY: Final = 0.002
"""Probability below which a class has no bar."""

BAND_STD: Final = 2.0
"""Half length of the noise's bars, in standard deviations."""

SAME: Final = 0.01
"""Part of the range of readings within which two ways are one line."""

MOST_SPECIMENS: Final = 4
"""Specimens up to which each has charts of its own."""

BAR_IN: Final = 0.34
"""Height of a bar with its name, in inches."""

FITTED: Final = ("before", "nuisances fitted", "blue")
"""Column, name and colour of the simulation without a cause."""

OVERLAYS: Final = Look(panel_in=(4.6, 3.4), dpi=150, titled=True, key="below")
GAIN: Final = Look(panel_in=(4.8, 3.6), dpi=150, key="above")


def draw(diagnosis: DiagnosisFile, readings: pd.DataFrame, out: Path) -> list[Path]:
    """Draw ``overlay.png``, ``probabilities.png`` and ``gain.png``.

    Args:
        diagnosis: content of ``diagnosis.json``.
        readings: a table with the columns channel, experiment, specimen, run, branch, pressure_kPa,
            displacement_mm, value, noise, configured, before, after.
        out: folder.

    Returns:
        The files.

    Raises:
        WriteError: one line.
    """
    bars = probabilities(diagnosis)
    size = (6.4, 0.9 + BAR_IN * len(bars.y.names))
    drawn = [
        write(overlays(diagnosis, readings), out / "overlay.png", OVERLAYS),
        write([bars], out / "probabilities.png", Look(panel_in=size, dpi=150)),
    ]
    if diagnosis.gain:
        drawn.append(write(gain(diagnosis), out / "gain.png", GAIN))
    return drawn


@dataclass(frozen=True, slots=True)
class ReadingsPanel:
    """Readings of one channel in one chart.

    Attributes:
        title: experiment, and specimen if there are several.
        channel: that is read.
        part: its rows.
    """

    title: str
    channel: Channel
    part: pd.DataFrame

    @property
    def over(self) -> Channel:
        """Channel of the horizontal axis: the pressure if all rows have it, else the travel."""
        return PRESSURE if self.part[PRESSURE.name].notna().all() else DISPLACEMENT

    @property
    def across(self) -> Axis:
        """The horizontal axis."""
        return Axis(self.over.label, self.over.symbol)


def panels(readings: pd.DataFrame) -> list[ReadingsPanel]:
    """Part readings into charts.

    Args:
        readings: the table of :func:`draw`.

    Returns:
        A panel for each channel of an experiment; of few specimens one for each of them.
    """
    shown = []
    for (experiment, name), part in readings.groupby(["experiment", "channel"], sort=False):
        title, channel = str(experiment).replace("_", " "), CHANNELS[str(name)]
        specimens = list(dict.fromkeys(part["specimen"]))
        if 1 < len(specimens) <= MOST_SPECIMENS and experiment != "coupon":
            for specimen in specimens:
                of_specimen = part[part["specimen"] == specimen]
                shown.append(ReadingsPanel(f"{title}, {specimen}", channel, of_specimen))
        else:
            shown.append(ReadingsPanel(title, channel, part))
    return shown


def _extended(diagnosis: DiagnosisFile) -> tuple[str, str, Colour]:
    """Column, name and colour of what was fitted: with the leading causes, if it has any."""
    causes = [e.replace("_", " ") for e in diagnosis.fits[0].effects] if diagnosis.fits else []
    return ("after", f"extended by {' and '.join(causes)}", "orange") if causes else FITTED


def overlays(diagnosis: DiagnosisFile, readings: pd.DataFrame) -> list[Chart]:
    """Make charts of measured and simulated readings, with the residuals below.

    Args:
        diagnosis: content of ``diagnosis.json``.
        readings: the table of :func:`draw`.

    Returns:
        A chart for each channel of an experiment, or of a specimen.
    """
    extended = _extended(diagnosis)
    charts = []
    for panel in panels(readings):
        part, over, channel = panel.part, panel.over.name, panel.channel
        half = BAND_STD * part["noise"]
        legend = f"measured, ± {BAND_STD:g} std"
        series = [_points(part, over, part["value"], legend, "ink", half)]
        series += lines(part, over, "configured", "as configured", "grey", "dots")
        series += lines(part, over, extended[0], *extended[1:], "line")
        residuals, rms = [], [f"{_rms(part, 'configured'):.3g} as configured"]
        for column, name, colour in dict.fromkeys((FITTED, extended)):
            bars = half if column == extended[0] else None
            residuals.append(_points(part, over, part[column] - part["value"], name, colour, bars))
            rms.append(f"{_rms(part, column):.3g} {name}")
        words, unit = channel.title.lower(), channel.symbol
        noise = float(np.sqrt(np.square(part["noise"]).mean()))
        note = f"Residuals, root mean square in {unit}: {', '.join(rms)}; noise {noise:.2g}."
        up = Axis(f"Simulated − measured ({unit})", unit, "simulated − measured")
        alt = f"{panel.title}: simulated less measured {words}, with the noise"
        below = Chart("", panel.across, up, residuals, [Mark(0.0)], alt=alt)
        alt = f"{panel.title}: measured {words} with its noise, and the simulation."
        up = Axis(channel.label, unit)
        title = f"{panel.title}: {words}"
        charts.append(Chart(title, panel.across, up, series, note=note, alt=alt, below=below))
    return charts


def _points(
    part: pd.DataFrame, over: str, y: pd.Series, name: str, colour: Colour, half: pd.Series | None
) -> Series:
    """Points of one chart, with bars of this half length."""
    low, high = (None, None) if half is None else (y - half, y + half)
    return Series(name, part[over].to_numpy(float), y.to_numpy(float), "points", None, low, high,
                  list(map(str, part["branch"])), colour)  # fmt: skip


def _rms(part: pd.DataFrame, column: str) -> float:
    return float(np.sqrt(np.square(part[column] - part["value"]).mean()))


def lines(
    part: pd.DataFrame, over: str, column: str, name: str, colour: Colour, style: Style
) -> list[Series]:
    """Make one line for each run that differs.

    A curve is drawn once: that of an elastic body there and back, and that of specimens that are
    simulated alike. Dashes that lie on one another look like a solid line.

    Args:
        part: rows of one chart.
        over: column of the horizontal axis.
        column: simulated values.
        name: what the key calls them.
        colour: of the lines.
        style: of the lines.

    Returns:
        The lines; those after the first have no name.
    """
    drawn: list[pd.DataFrame] = []
    series = []
    for _, run in part.groupby("run", sort=False):
        shown = first_way(run, over, column)
        if not any(_along(shown, other, over, column) for other in drawn):
            values = shown[over].to_numpy(float), shown[column].to_numpy(float)
            series.append(Series("" if drawn else name, *values, style, colour=colour))
            drawn.append(shown)
    return series


def first_way(run: pd.DataFrame, over: str, column: str) -> pd.DataFrame:
    """Take the first way of a run alone, where all others go along it; measured loads scatter."""
    first = run.iloc[ways(run[over].to_numpy(dtype=float))[0]].sort_values(over)
    return first if _along(run, first, over, column) else run


def _along(run: pd.DataFrame, other: pd.DataFrame, over: str, column: str) -> bool:
    """Tell if a run goes along another, whose load only grows; its ends may lie beyond."""
    if not other[over].is_monotonic_increasing:
        return False
    shared = run[run[over].between(other[over].iloc[0], other[over].iloc[-1])]
    if len(shared) < max(2, len(run) - 2):
        return False
    along = np.interp(shared[over], other[over], other[column])
    apart = float(np.abs(shared[column] - along).max())
    return apart < SAME * float(run[column].max() - run[column].min())


def ways(load: np.ndarray) -> list[slice]:
    """The parts of a run along which the load only grows, or only falls; turns belong to both."""
    steps = pd.Series(np.sign(np.diff(load))).replace(0, np.nan).ffill().bfill().fillna(1)
    turns = np.flatnonzero(np.diff(steps.to_numpy())) + 1  # a wait belongs to the way before it
    ends = [0, *turns, len(load) - 1]
    return [slice(first, last + 1) for first, last in pairwise(ends)]


def probabilities(diagnosis: DiagnosisFile, least: float = LEAST_PROBABILITY) -> Chart:
    """Make the chart of the probability of each cause.

    Args:
        diagnosis: content of ``diagnosis.json``.
        least: probability below which a cause has no bar.

    Returns:
        Bars, the longest first.
    """
    by_cause = {cause.name.replace("_", " "): cause.probability for cause in diagnosis.causes}
    shown = {name: p for name, p in by_cause.items() if p >= least}
    shown |= beside_causes(diagnosis)
    names = sorted(shown, key=lambda name: -shown[name])
    bars = []
    for colour, of_cause in (("green", True), ("grey", False)):
        places = [i for i, name in enumerate(names) if (name in by_cause) is of_cause]
        values = [shown[names[i]] for i in places]
        said = ["< 0.01" if p < LEAST else chance(p) for p in values]
        bars.append(Series("", values, places, "bar", colour=colour, said=said))
    across = Axis("Probability that it takes part", ends=(0.0, 1.1))
    title = "Probability that each cause takes part"
    note = "Two causes can act together, so the numbers may add up to more than 1."
    return Chart(title, across, Axis("", names=names), bars, note=note)


def gain(diagnosis: DiagnosisFile) -> list[Chart]:
    """Make charts of the error on readings that were left out.

    Args:
        diagnosis: content of ``diagnosis.json``.

    Returns:
        A chart for each channel, with a bar for each model and what was left out.
    """
    kinds: list[tuple[str, str, Colour]] = [
        ("before", "as configured", "pale"), ("nuisances", "nuisances refitted", "blue"),
        ("process", "process without cause", "grey"), ("cause", "with the cause", "orange"),
    ]  # fmt: skip
    charts = []
    for name in dict.fromkeys(row.channel for row in diagnosis.gain):
        rows, channel = [row for row in diagnosis.gain if row.channel == name], CHANNELS[name]
        low, high = ([getattr(row, f"cause_{end}") for row in rows] for end in ("low", "high"))
        bars = [
            Series(text, [getattr(row, kind) for row in rows], range(len(rows)), "bar",
                   low=low if kind == "cause" else None, high=high if kind == "cause" else None,
                   colour=colour)
            for kind, text, colour in kinds
        ]  # fmt: skip
        across = Axis(f"Error on left-out readings, {channel.label}", channel.symbol, log=True)
        names = Axis("", names=[f"{row.left_out} left out" for row in rows])
        charts.append(Chart(f"Before and after: {channel.title.lower()}", across, names, bars))
    return charts

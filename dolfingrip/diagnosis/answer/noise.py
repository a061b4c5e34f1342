"""Noise of the instruments: as the laboratory told it, else estimated from their readings.

    σ² = Σ (Δᵈy)² / (n C(2d, d)),   d = 3,

over the third differences Δ³y of the readings of one branch, in the order of the control. If rows
are dense the curve itself has no such differences, and independent noise σ gives them a variance of
C(6, 3) σ² = 20 σ² (von Neumann, Ann. Math. Stat. 12, 1941, with first differences). A branch of at
least ``DATA.dense`` rows is dense. Cycles from the second on repeat one another: if branches are
not dense, half the variance of their differences is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np
import pandas as pd

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import DATA
from dolfingrip.files.diagnosis import NoiseSource


@dataclass(frozen=True, slots=True)
class InstrumentNoise:
    """Noise of every reading, aligned with ``Measurement.listed``.

    Attributes:
        independent: (n,) standard deviation of the part that differs from reading to reading, in
            the column's unit.
        correlated: (n,) standard deviation of the part that drifts along a run; 0 if none is told.
        correlation_time_s: (n,) correlation time of that part; infinite: as long as the run.
        control: (n,) standard deviation of the reading of the control (kPa or mm).
        sources: of the numbers that the laboratory does not tell.
    """

    independent: np.ndarray
    correlated: np.ndarray
    correlation_time_s: np.ndarray
    control: np.ndarray
    sources: tuple[NoiseSource, ...]


def instrument_noise(measurement: Measurement) -> InstrumentNoise:
    """The noise of each reading of ``measurement``."""
    listed = measurement.listed
    independent, correlated, control = np.zeros((3, len(listed)))
    correlation_time_s = np.full(len(listed), np.inf)
    sources: list[NoiseSource] = []
    for (number, column), part in listed.groupby(["test", "column"], sort=False):
        test = measurement.tests[int(number)]
        at = part.index.to_numpy()
        std = test.setup.noise.get(str(column))
        if std is None:
            source = _estimated(measurement, test, str(column))
            std = source.std
            sources.append(source)
        independent[at] = std
        correlated[at] = test.setup.correlated_noise.get(str(column), 0.0)
        if test.setup.correlation_time_s is not None:
            correlation_time_s[at] = test.setup.correlation_time_s
        control[at] = test.sigma
    return InstrumentNoise(
        independent, correlated, correlation_time_s, control, tuple(dict.fromkeys(sources))
    )


def drifting(listed: pd.DataFrame, noise: InstrumentNoise) -> np.ndarray:
    """Noise that drifts along a run, told by the laboratory."""
    if not noise.correlated.any():
        return np.zeros((len(listed), len(listed)))
    time_s = listed["time_s"].to_numpy()
    run = (listed["test"].astype(str) + listed["column"].astype(str)).to_numpy()
    lasting = np.where(np.isfinite(noise.correlation_time_s), noise.correlation_time_s, 1e6)
    same = run[:, None] == run
    fading = np.exp(-np.abs(time_s[:, None] - time_s) / lasting[:, None])
    return np.outer(noise.correlated, noise.correlated) * np.where(same, fading, 0.0)


def _estimated(measurement: Measurement, test: SpecimenTest, column: str) -> NoiseSource:
    """A standard deviation, and its source."""
    rows = measurement.rows(test.number)
    std, source = CHANNELS[column].noise, "guess"
    for parts, name in (
        (_repeats(rows, test.control, column), "repeats"),
        (_differences(rows, test.control, column), "scatter"),
    ):
        off = np.concatenate([np.empty(0), *parts])
        # rounded readings may not differ at all
        if len(off) >= DATA.fewest_differences and off.any():
            std, source = float(np.sqrt(np.mean(off**2))), name
    return NoiseSource.model_validate(
        {"column": column, "test": str(test), "std": std, "source": source}
    )


def _differences(rows: pd.DataFrame, control: str, column: str) -> Iterator[np.ndarray]:
    """Third differences of dense ramps, divided by those of noise of 1."""
    for (branch, _), part in rows.groupby(["branch", "leg"], sort=False):
        in_order = part if branch == "hold" else part.sort_values(control)
        value, order = in_order[column].dropna().to_numpy(), DATA.differences
        if len(value) >= DATA.dense:
            yield np.diff(value, order) / np.sqrt(comb(2 * order, order))


def _repeats(rows: pd.DataFrame, control: str, column: str) -> Iterator[np.ndarray]:
    """Differences between successive cycles from the second on, divided by √2."""
    for _, branch in rows[rows["cycle"] > 1].groupby("branch", sort=False):
        cycles = [part for _, part in branch.groupby("cycle", sort=True)]
        for before, after in pairwise(cycles):
            if len(before) != len(after):
                continue
            away = after[control].to_numpy() - before[control].to_numpy()
            if np.abs(away).max() > DATA.same_place * max(float(np.ptp(before[control])), 1e-9):
                continue
            change = after[column].to_numpy() - before[column].to_numpy()
            yield change[~np.isnan(change)] / np.sqrt(2)

"""Noise of the instruments: as the laboratory told it, else estimated from their readings.

    σ² = Σ (Δᵈy)² / (n C(2d, d)),   d = 3,

over the third differences Δ³y of the readings of one branch, in the order of the control. If rows
are dense the curve itself has no such differences, and independent noise σ gives them a variance of
C(6, 3) σ² = 20 σ² (von Neumann, Ann. Math. Stat. 12, 1941, with first differences). A branch of at
least ``Policy.dense`` rows is dense. Cycles from the second on repeat one another: if branches are
not dense, half the variance of their differences is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import comb

import numpy as np
import pandas as pd
from scipy.spatial.distance import cdist

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.table import of_markers
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.diagnosis import NoiseSource


def instrument_noise(measurement: Measurement) -> tuple[pd.DataFrame, tuple[NoiseSource, ...]]:
    """The noise of each reading of a measurement, aligned with ``Measurement.listed``.

    Args:
        measurement: the readings.

    Returns:
        ``independent``: standard deviation of the part that differs from reading to reading, in the
        column's unit; ``correlated``: of the part that drifts along a run, 0 if none is told, with
        its ``correlation_time_s`` and ``correlation_length_mm``, infinite: as long as the run;
        ``control``: of the reading of the control (kPa or mm). And sources of the numbers that the
        laboratory does not tell.
    """
    listed = measurement.listed
    columns = [
        "independent", "correlated", "correlation_time_s", "correlation_length_mm", "control"
    ]  # fmt: skip
    noise = pd.DataFrame(0.0, index=listed.index, columns=columns)
    sources: list[NoiseSource] = []
    for (number, column), part in listed.groupby(["test", "column"], sort=False):
        test, name = measurement.tests[int(number)], str(column)
        setup, std = test.setup, test.setup.noise.get(name)
        if std is None:
            sources.append(_estimated(measurement, test, name))
            std = sources[-1].std
        lasting = setup.correlation_time_s, setup.correlation_length_mm
        drifts = setup.correlated_noise.get(name, 0.0)
        noise.loc[part.index] = std, drifts, *lasting, test.sigma
    return noise, tuple(dict.fromkeys(sources))


def drifting(measurement: Measurement, noise: pd.DataFrame) -> np.ndarray:
    """Noise that drifts along a run, told by the laboratory, (n, n).

    It fades with the time between two readings of a column, and with how far the markers have moved
    between them, as what is beside a mark in a picture changes with it.

    Args:
        measurement: the readings.
        noise: of :func:`instrument_noise`.
    """
    listed, std = measurement.listed, noise["correlated"].to_numpy()
    if not std.any():
        return np.zeros((len(listed), len(listed)))
    run = (listed["test"].astype(str) + listed["column"].astype(str)).to_numpy()
    rows = measurement.readings.iloc[listed["row"]]
    places_mm = rows[[*of_markers(rows)]].fillna(0.0).to_numpy()
    fading = np.where(run[:, None] == run, 1.0, 0.0)
    for at, length in (
        (listed[["time_s"]].to_numpy(), noise["correlation_time_s"]),
        (places_mm, noise["correlation_length_mm"]),
    ):
        fading *= np.exp(-cdist(at, at) / length.to_numpy()[:, None])
    return np.outer(std, std) * fading


def _estimated(measurement: Measurement, test: SpecimenTest, column: str) -> NoiseSource:
    """A standard deviation, and its source."""
    rows, policy = measurement.rows(test.number), measurement.policy
    std, source = CHANNELS[column].noise, "guess"
    for parts, name in (
        (_repeats(rows, test.control, column, policy.alike), "repeats"),
        (_differences(rows, test.control, column, policy), "scatter"),
    ):
        off = np.concatenate([np.empty(0), *parts])
        # rounded readings may not differ at all
        if len(off) >= policy.few and off.any():
            std, source = float(np.sqrt(np.mean(off**2))), name
    return NoiseSource.model_validate(
        {"column": column, "test": str(test), "std": std, "source": source}
    )


def _differences(
    rows: pd.DataFrame, control: str, column: str, policy: Policy
) -> Iterator[np.ndarray]:
    """Third differences of dense ramps, divided by those of noise of 1."""
    for (branch, _), part in rows.groupby(["branch", "leg"], sort=False):
        in_order = part if branch == "hold" else part.sort_values(control)
        value, order = in_order[column].dropna().to_numpy(), policy.differences
        if len(value) >= policy.dense:
            yield np.diff(value, order) / np.sqrt(comb(2 * order, order))


def _repeats(rows: pd.DataFrame, control: str, column: str, off: float) -> Iterator[np.ndarray]:
    """Differences between successive cycles from the second on, divided by √2."""
    for _, branch in rows[rows["cycle"] > 1].groupby("branch", sort=False):
        cycles = [part for _, part in branch.groupby("cycle", sort=True)]
        for before, after in pairwise(cycles):
            if len(before) != len(after):
                continue
            away = after[control].to_numpy() - before[control].to_numpy()
            if np.abs(away).max() > off * max(float(np.ptp(before[control])), 1e-9):
                continue
            change = after[column].to_numpy() - before[column].to_numpy()
            yield change[~np.isnan(change)] / np.sqrt(2)

"""What readings differ by beside causes: noise, numbers of the rig, scatter of specimens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.diagnosis.answer.scatter import Scatter, between
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.discrepancy import Along
from dolfingrip.diagnosis.data import noise as instruments
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.groups import SimulationGroup
from dolfingrip.diagnosis.simulation.nuisances import Nuisance

SLACK: Final = "coupon_slack_mm"


@dataclass(frozen=True, eq=False)
class Errors:
    """Everything but causes that readings differ by.

    Attributes:
        covariance: shape (n, n).
        noise: of instruments and gauge, standard deviations, shape (n,).
        along: where the readings lie, for a discrepancy that all specimens share.
        signal: a smooth curve through the readings, shape (n,).
        shared: numbers of the rig.
        fitted: covariance of what a fit gives the rig and each specimen, shape (n, n).
        scatter: of the specimens.
        sentences: where the noise comes from.
    """

    covariance: np.ndarray
    noise: np.ndarray
    along: Along
    signal: np.ndarray
    shared: tuple[Nuisance, ...]
    fitted: np.ndarray
    scatter: Scatter
    sentences: tuple[str, ...]


def together(
    measurement: Measurement,
    along: Along,
    signal: np.ndarray,
    steep: np.ndarray,
    shared: Sequence[Nuisance],
    fitted: np.ndarray,
) -> Errors:
    """Everything but causes, as one covariance.

    Args:
        measurement: of any specimens.
        along: where its readings lie.
        signal: a smooth curve through them, shape (n,).
        steep: its slope by the control, whose gauge has noise, shape (n,).
        shared: numbers of the rig.
        fitted: covariance of what else a fit gives the rig and each specimen, shape (n, n).
    """
    listed = measurement.listed()
    told = instruments.noise(measurement)
    covariance = np.diag(np.maximum(told.independent, 1e-9) ** 2) + drifting(listed, told)
    # one reading of the control stands behind all readings of its row
    gauge, row = steep * told.control, listed["row"].to_numpy()
    covariance += np.outer(gauge, gauge) * (row[:, None] == row)
    noise = np.sqrt(np.diag(covariance))
    fitted = fitted + sum(np.outer(each.change, each.change) for each in shared)
    covariance += fitted
    scatter, apart = between(measurement, covariance, along, signal)
    specimen = listed["specimen"].to_numpy()
    stiff = scatter.scale * signal
    fitted = fitted + np.outer(stiff, stiff) * (specimen[:, None] == specimen)
    return Errors(
        covariance + apart, noise, along, signal, tuple(shared), fitted, scatter, told.sentences
    )


def followed(listed: pd.DataFrame, along: Along, base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the model's readings are multiplied by to be a smooth curve through those measured.

    A polynomial of the load for each channel, protocol and branch.

    Returns:
        The factor, shape (n,), and its derivative by the load, shape (n,).
    """
    value = listed["value"].to_numpy()
    found, turned = np.zeros(len(value)), np.zeros(len(value))
    parts = listed.assign(block=along.block).groupby(["block", "cycle", "branch"], sort=False)
    for _, part in parts:
        at = part.index.to_numpy()
        x = 2 * along.load[at] - 1
        degree = int(np.clip(len(np.unique(np.round(x / 2, 4))) // 4, 0, POLICY.smooth))
        powers = np.polynomial.chebyshev.chebvander(x, degree)
        weights, *_ = np.linalg.lstsq(base[at, None] * powers, value[at], rcond=1e-8)
        found[at] = powers @ weights
        by_x = np.polynomial.chebyshev.chebder(weights)
        turned[at] = 2 * np.polynomial.chebyshev.chebval(x, by_x)
    return found, turned


def lying(measurement: Measurement, groups: Sequence[SimulationGroup], load: np.ndarray) -> Along:
    """Where a measurement's readings lie.

    Args:
        measurement: of any specimens.
        groups: tests that are simulated together, whose channels share a discrepancy.
        load: of each row by the largest, shape (rows,).
    """
    listed, rows = measurement.listed(), measurement.readings
    number = rows["test"].to_numpy()
    path = np.zeros(len(rows))
    for test in measurement.tests:
        mine = np.flatnonzero(number == test.number)
        path[mine] = discrepancy.path_of(load[mine], rows["time_s"].to_numpy()[mine])
    row, column = listed["row"].to_numpy(), listed["column"].to_numpy()
    group = np.zeros(len(listed), dtype=int)
    for place, each in enumerate(groups):
        group[np.isin(listed["test"].to_numpy(), each.tests)] = place
    names, channel = np.unique(column.astype(str), return_inverse=True)
    block = group * len(names) + channel
    value = listed["value"].to_numpy()
    size = np.zeros(len(listed))
    for each in set(block):
        size[block == each] = np.sqrt(np.mean(value[block == each] ** 2))
    return Along(load[row], path[row], block, size)


def drifting(listed: pd.DataFrame, told: instruments.InstrumentNoise) -> np.ndarray:
    """Noise that drifts along a run, told by the laboratory."""
    if not told.correlated.any():
        return np.zeros((len(listed), len(listed)))
    time_s = listed["time_s"].to_numpy()
    run = (listed["test"].astype(str) + listed["column"].astype(str)).to_numpy()
    lasting = np.where(np.isfinite(told.correlation_time_s), told.correlation_time_s, 1e6)
    same = run[:, None] == run
    fading = np.exp(-np.abs(time_s[:, None] - time_s) / lasting[:, None])
    return np.outer(told.correlated, told.correlated) * np.where(same, fading, 0.0)

"""Noise, nuisances and the scatter of specimens of coupons, as one covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy.linalg

from dolfingrip.channels import DISPLACEMENT
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.discrepancy import Along
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation
from dolfingrip.diagnosis.data import noise as instruments
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.parameter import named


@dataclass(frozen=True, eq=False)
class Scatter:
    """How far the specimens differ from one another.

    Attributes:
        scale: relative standard deviation of their stiffness.
        told_scale: as the laboratory told, or usual.
        shape: individual deviation, by the root mean square of a channel.
        estimated: whether the readings of several specimens tell these.
    """

    scale: float
    told_scale: float
    shape: float
    estimated: bool


@dataclass(frozen=True, eq=False)
class CouponErrors:
    """Everything but causes that readings of coupons differ by.

    Attributes:
        covariance: shape (n, n).
        noise: of instruments and gauge, standard deviations, shape (n,).
        along: where the readings lie, for a discrepancy that all specimens share.
        signal: a smooth curve through the readings, shape (n,).
        slack: changes by one usual slack of all coupons, shape (n,).
        scatter: of the specimens.
        sentences: where the noise comes from.
        guessed: whether the noise is a guess.
    """

    covariance: np.ndarray
    noise: np.ndarray
    along: Along
    signal: np.ndarray
    slack: np.ndarray
    scatter: Scatter
    sentences: tuple[str, ...]
    guessed: bool


def errors(simulation: CouponSimulation) -> CouponErrors:
    """The covariance of a measurement's coupons."""
    measurement = simulation.measurement
    listed = measurement.listed()
    told = instruments.noise(measurement)
    value = listed["value"].to_numpy()
    base, slope = simulation.base(), simulation.slopes()
    along = _along(simulation)
    signal = smooth(listed, along, base, value)
    ratio = np.where(np.abs(base) > 1e-12, signal / np.where(base == 0, 1.0, base), 1.0)
    steep = slope * ratio
    covariance = np.diag(np.maximum(told.independent, 1e-9) ** 2)
    covariance += _drifting(listed, told)
    # one reading of the travel stands behind all readings of its row
    gauge = np.where(np.isfinite(steep), steep, 0.0) * told.control
    row = listed["row"].to_numpy()
    covariance += np.outer(gauge, gauge) * (row[:, None] == row)
    noise = np.sqrt(np.diag(covariance))
    test = listed["test"].to_numpy()
    for number, each in enumerate(measurement.tests):
        mine = test == number
        slack = np.where(mine, steep, 0.0) * each.setup.nuisances["coupon_slack_mm"]
        covariance += np.outer(slack, slack)
    covariance += _own(simulation, base, ratio)
    usual = measurement.tests[0].setup.nuisances["coupon_slack_mm"]
    scatter, between = _between(simulation, covariance, along, signal)
    guessed = any("guess" in sentence for sentence in told.sentences)
    return CouponErrors(
        covariance + between, noise, along, signal, steep * usual, scatter, told.sentences, guessed
    )


def smooth(listed: pd.DataFrame, along: Along, base: np.ndarray, value: np.ndarray) -> np.ndarray:
    """A smooth curve through the readings of each channel, protocol and branch, shape (n,)."""
    found = np.zeros(len(value))
    parts = listed.assign(block=along.block).groupby(["block", "cycle", "branch"], sort=False)
    for _, part in parts:
        at = part.index.to_numpy()
        x = along.load[at]
        degree = int(np.clip(len(np.unique(np.round(x, 4))) // 4, 0, 4))
        columns = base[at, None] * (2 * x[:, None] - 1) ** np.arange(degree + 1)
        weights, *_ = np.linalg.lstsq(columns, value[at], rcond=1e-8)
        found[at] = columns @ weights
    return found


def _along(simulation: CouponSimulation) -> Along:
    measurement = simulation.measurement
    listed, rows = measurement.listed(), measurement.readings
    largest = float(np.nanmax(np.abs(rows[DISPLACEMENT.name]))) or 1.0
    gauges = np.array(
        [test.setup.applied(simulation.config).coupon.gauge_length_mm for test in measurement.tests]
    )
    number = rows["test"].to_numpy()
    load = rows[DISPLACEMENT.name].to_numpy() / gauges[number]
    largest = float(np.nanmax(np.abs(load))) or 1.0
    load = load / largest
    path = np.zeros(len(rows))
    for test in measurement.tests:
        mine = np.flatnonzero(number == test.number)
        path[mine] = discrepancy.path_of(load[mine], rows["time_s"].to_numpy()[mine])
    row, column = listed["row"].to_numpy(), listed["column"].to_numpy()
    group = np.zeros(len(listed), dtype=int)
    for place, each in enumerate(simulation.groups):
        group[np.isin(listed["test"].to_numpy(), each.tests)] = place
    names = {name: i for i, name in enumerate(sorted(set(column)))}
    block = group * len(names) + np.array([names[name] for name in column])
    value = listed["value"].to_numpy()
    size = np.zeros(len(listed))
    for each in set(block):
        size[block == each] = np.sqrt(np.mean(value[block == each] ** 2))
    return Along(load[row], path[row], block, size)


def _drifting(listed: pd.DataFrame, told: instruments.InstrumentNoise) -> np.ndarray:
    """Noise that drifts along a run, told by the laboratory."""
    if not told.correlated.any():
        return np.zeros((len(listed), len(listed)))
    time_s = listed["time_s"].to_numpy()
    run = (listed["test"].astype(str) + listed["column"].astype(str)).to_numpy()
    lasting = np.where(np.isfinite(told.correlation_time_s), told.correlation_time_s, 1e6)
    same = run[:, None] == run
    fading = np.exp(-np.abs(time_s[:, None] - time_s) / lasting[:, None])
    return np.outer(told.correlated, told.correlated) * np.where(same, fading, 0.0)


def _own(simulation: CouponSimulation, base: np.ndarray, ratio: np.ndarray) -> np.ndarray:
    """Numbers of the configuration that the laboratory gave a standard deviation."""
    found = np.zeros((len(base), len(base)))
    nuisances = simulation.measurement.tests[0].setup.nuisances
    for key, std in nuisances.items():
        if "." not in key or not std:
            continue
        value = named(key).value(simulation.config)
        change = (simulation.base((f"{key}={value + std!r}",)) - base) * ratio
        found += np.outer(change, change)
    return found


def _between(
    simulation: CouponSimulation, covariance: np.ndarray, along: Along, signal: np.ndarray
) -> tuple[Scatter, np.ndarray]:
    """What one specimen differs from another by: its stiffness, and its own smooth deviation.

    Of several specimens the sizes are those that make their differences most probable: a curve that
    all have in common is taken out first (restricted likelihood; Patterson & Thompson, Biometrika
    58, 1971), so that no hypothesis about it matters.
    """
    measurement = simulation.measurement
    listed = measurement.listed()
    specimen = listed["specimen"].to_numpy()
    names = sorted(set(specimen))
    scaled = np.array([name != "transverse_strain" for name in listed["column"]])
    same = specimen[:, None] == specimen
    stiff = np.outer(signal * scaled, signal * scaled) * same
    shape = discrepancy.kernel(along) * same
    told = float(np.max([test.setup.nuisances["specimen_scale"] for test in measurement.tests]))
    if len(names) == 1:
        return (
            Scatter(0.0, told, POLICY.single_shape, estimated=False),
            POLICY.single_shape**2 * shape,
        )
    common = _common(listed, along)
    found: tuple[float, float, float] | None = None
    for factor in POLICY.specimen_scales:
        for level in POLICY.specimen_shapes:
            total = covariance + (factor * told) ** 2 * stiff + level**2 * shape
            likelihood = _restricted(total, common, listed["value"].to_numpy())
            if found is None or likelihood > found[0] + 0.5:
                found = likelihood, factor * told, level
    assert found is not None
    _, scale, level = found
    return (
        Scatter(scale, told, level, estimated=True), scale**2 * stiff + level**2 * shape,
    )  # fmt: skip


def _common(listed: pd.DataFrame, along: Along) -> np.ndarray:
    """Columns of any smooth curve that all specimens share, (n, k)."""
    columns: list[np.ndarray] = []
    parts = listed.assign(block=along.block).groupby(["block", "cycle", "branch"], sort=False)
    for _, part in parts:
        at = part.index.to_numpy()
        x = along.load[at]
        distinct = len(np.unique(np.round(x, 3)))
        degree = int(np.clip(distinct // 3, 0, 7))
        own = np.zeros((len(along.load), degree + 1))
        span = max(float(np.ptp(x)), 1e-9)
        own[at] = np.polynomial.chebyshev.chebvander(2 * (x - x.min()) / span - 1, degree)
        columns.append(own)
    return np.hstack(columns)


def _restricted(covariance: np.ndarray, common: np.ndarray, value: np.ndarray) -> float:
    lower = scipy.linalg.cholesky(covariance, lower=True)
    white = scipy.linalg.solve_triangular(lower, np.column_stack([value, common]), lower=True)
    q, r = np.linalg.qr(white[:, 1:])
    rest = white[:, 0] - q @ (q.T @ white[:, 0])
    determinant = np.log(np.diag(lower)).sum() + np.log(np.abs(np.diag(r)) + 1e-300).sum()
    return float(-0.5 * rest @ rest - determinant)


def rows_of(measurement_tests: Sequence[int], listed: pd.DataFrame) -> np.ndarray:
    """Places of the readings of some tests."""
    return np.flatnonzero(np.isin(listed["test"].to_numpy(), measurement_tests))

"""Noise, nuisances and the scatter of specimens of coupons, as one covariance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
import scipy.linalg

from dolfingrip.channels import DISPLACEMENT
from dolfingrip.diagnosis.answer.errors import SLACK, Errors, Scatter, Shared
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.discrepancy import Along
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation
from dolfingrip.diagnosis.data import noise as instruments
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.groups import SimulationGroup
from dolfingrip.parameter import named


def errors(simulation: CouponSimulation) -> Errors:
    """The covariance of a measurement's coupons."""
    measurement = simulation.measurement
    listed = measurement.listed()
    told = instruments.noise(measurement)
    base = simulation.base()
    along = _along(simulation)
    signal, steep = smooth(simulation, along, base)
    covariance = np.diag(np.maximum(told.independent, 1e-9) ** 2)
    covariance += drifting(listed, told)
    # one reading of the travel stands behind all readings of its row
    gauge = steep * told.control
    row = listed["row"].to_numpy()
    covariance += np.outer(gauge, gauge) * (row[:, None] == row)
    noise = np.sqrt(np.diag(covariance))
    test = listed["test"].to_numpy()
    slack = np.array([each.setup.nuisances[SLACK] for each in measurement.tests])[test]
    late = slack * steep
    fitted = POLICY.own_slack * np.outer(late, late) * (test[:, None] == test)
    usual = float(slack.max())
    share = float(np.sqrt(1 - POLICY.own_slack))
    shared = (
        Shared(SLACK, "mm", share * usual, share * late),
        *_told(simulation, base, signal),
    )
    for each in shared:
        fitted += np.outer(each.change, each.change)
    covariance += fitted
    scatter, apart = between(measurement, covariance, along, signal)
    specimen = listed["specimen"].to_numpy()
    stiff = scatter.scale * signal
    fitted = fitted + np.outer(stiff, stiff) * (specimen[:, None] == specimen)
    guessed = any("guess" in sentence for sentence in told.sentences)
    return Errors(
        covariance + apart, noise, along, signal, shared, fitted, scatter, told.sentences, guessed
    )


def smooth(
    simulation: CouponSimulation, along: Along, base: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A smooth curve through the readings of each channel, protocol and branch, and its slope.

    The configured model times a polynomial of the load. The slope is the curve's own: a material
    that softens answers a slip of the travel at its toe by more, and later by less, than the
    configured one.

    Returns:
        Shapes (n,), and (n,) for each mm of travel.
    """
    listed = simulation.measurement.listed()
    slope = simulation.slopes()
    slope = np.where(np.isfinite(slope), slope, 0.0)
    travel = listed["control"].to_numpy()
    moved = np.abs(travel) > 1e-9
    by_mm = np.where(moved, along.load / np.where(moved, travel, 1.0), 0.0)
    factor, turned = followed(listed, along, base)
    moves = slope != 0  # a wait has no slope
    return base * factor, slope * factor + moves * base * turned * by_mm


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


def _along(simulation: CouponSimulation) -> Along:
    measurement = simulation.measurement
    rows = measurement.readings
    gauges = np.array(
        [test.setup.applied(simulation.config).coupon.gauge_length_mm for test in measurement.tests]
    )
    number = rows["test"].to_numpy()
    load = rows[DISPLACEMENT.name].to_numpy() / gauges[number]
    largest = float(np.nanmax(np.abs(load))) or 1.0
    return lying(measurement, simulation.groups, load / largest)


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
    names = {name: i for i, name in enumerate(sorted(set(column)))}
    block = group * len(names) + np.array([names[name] for name in column])
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


def _told(simulation: CouponSimulation, base: np.ndarray, signal: np.ndarray) -> Iterator[Shared]:
    """Numbers of the configuration that the laboratory gave a standard deviation."""
    ratio = np.where(np.abs(base) > 1e-12, signal / np.where(base == 0, 1.0, base), 1.0)
    for key, std in simulation.measurement.tests[0].setup.nuisances.items():
        if "." in key and std:
            change = simulation.base(moved={key: std}) - base
            yield Shared(key, named(key).unit, std, change * ratio)


def between(
    measurement: Measurement, covariance: np.ndarray, along: Along, signal: np.ndarray
) -> tuple[Scatter, np.ndarray]:
    """What one specimen differs from another by: its stiffness, and its own smooth deviation.

    Of several specimens their differences tell both: a curve that all have in common is taken out
    first (restricted likelihood; Patterson & Thompson, Biometrika 58, 1971), so that no hypothesis
    about it matters. The stiffness' size is the most probable. The shape's variance is the expected
    one: of few specimens the most probable is often 0, and what two have in common by chance would
    be taken for a cause.
    """
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
    levels = np.array(POLICY.specimen_shapes)
    likelihood = np.array([
        [
            _restricted(
                covariance + (factor * told) ** 2 * stiff + level**2 * shape, common,
                listed["value"].to_numpy(),
            )
            for level in levels
        ]
        for factor in POLICY.specimen_scales
    ])  # fmt: skip
    best = 0
    for number, of in enumerate(likelihood.max(axis=1)):
        if of > likelihood[best].max() + 0.5:
            best = number
    scale = POLICY.specimen_scales[best] * told
    weights = np.exp(likelihood[best] - likelihood[best].max())
    level = float(np.sqrt(weights @ levels**2 / weights.sum()))
    return (
        Scatter(scale, told, level, estimated=True), scale**2 * stiff + level**2 * shape,
    )  # fmt: skip


def _common(listed: pd.DataFrame, along: Along) -> np.ndarray:
    """Columns of any curve that all specimens share, (n, k).

    It has as many numbers as one specimen has readings: what it cannot follow would be taken for
    scatter, and hide what the model misses of all specimens alike.
    """
    columns: list[np.ndarray] = []
    parts = listed.assign(block=along.block).groupby(["block", "cycle", "branch"], sort=False)
    for _, part in parts:
        at = part.index.to_numpy()
        x = along.load[at]
        each = int(part.groupby("test").size().median())
        degree = min(len(np.unique(np.round(x, 3))), each, POLICY.common) - 1
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

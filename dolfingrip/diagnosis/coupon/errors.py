"""Noise, nuisances and the scatter of specimens of coupons, as one covariance."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dolfingrip.channels import DISPLACEMENT
from dolfingrip.diagnosis.answer.errors import SLACK, Errors, followed, lying, together
from dolfingrip.diagnosis.core.discrepancy import Along
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import Nuisance
from dolfingrip.parameter import named


def errors(simulation: CouponSimulation) -> Errors:
    """The covariance of a measurement's coupons."""
    measurement = simulation.measurement
    base = simulation.base()
    along = _along(simulation)
    signal, steep = smooth(simulation, along, base)
    test = measurement.listed()["test"].to_numpy()
    slack = np.array([each.setup.nuisances[SLACK] for each in measurement.tests])
    late = slack[test] * steep
    own = POLICY.own_slack * np.outer(late, late) * (test[:, None] == test)
    share = float(np.sqrt(1 - POLICY.own_slack))
    shared = (
        Nuisance(SLACK, "mm", share * float(slack.max()), share * late),
        *_told(simulation, base, signal),
    )
    return together(measurement, along, signal, steep, shared, own)


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


def _told(simulation: CouponSimulation, base: np.ndarray, signal: np.ndarray) -> Iterator[Nuisance]:
    """Numbers of the configuration that the laboratory gave a standard deviation."""
    ratio = np.where(np.abs(base) > 1e-12, signal / np.where(base == 0, 1.0, base), 1.0)
    for key, std in simulation.measurement.tests[0].setup.nuisances.items():
        if "." in key and std:
            change = simulation.base(moved={key: std}) - base
            yield Nuisance(key, named(key).unit, std, change * ratio)

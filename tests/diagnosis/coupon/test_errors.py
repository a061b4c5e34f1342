"""What coupons differ by, on eight measured NinjaFlex specimens."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support.example import EXAMPLES

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.errors import SLACK, Errors, errors_of
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data.measurement import read, selected
from dolfingrip.files.diagnosis import Scatter

COUPONS = EXAMPLES / "coupons/ninjaflex_uniaxial.csv"


@pytest.fixture(scope="module")
def simulation() -> CouponSimulation:
    measurement, _ = selected(read([COUPONS], Config()), Config())
    return CouponSimulation(measurement, Config())


@pytest.fixture(scope="module")
def off(simulation: CouponSimulation) -> Errors:
    return errors_of(simulation)


def test_the_slope_is_the_readings_own(simulation: CouponSimulation, off: Errors) -> None:
    """Against lines through the readings of all specimens, in windows of 2 mm.

    neo-Hooke, scaled to the force, is half as steep at the toe and a fifth too steep at the end.
    """
    listed = simulation.measurement.listed
    x, y = listed["control"].to_numpy(), listed["value"].to_numpy()
    (slack,) = (each for each in off.rig if each.name == SLACK)
    steep = -slack.change / slack.std  # a coupon that is slack is pulled by less
    for middle in (3.0, 8.0, 14.0):
        near = np.abs(x - middle) < 1.0
        line = np.polynomial.Polynomial.fit(x[near], y[near], 1).convert().coef
        assert steep[near].mean() == pytest.approx(line[1], rel=0.1)


def test_what_specimens_share_is_no_scatter(off: Errors) -> None:
    """Their own smooth deviations are 0.2 % of the force; a slip of the rig is in none of them."""
    assert off.scatter.estimated
    assert off.scatter.shape <= 0.004
    assert off.scatter.scale <= 0.03


def test_a_slip_that_all_share_stays_in_the_rig(off: Errors) -> None:
    """Slack of one coupon moves the others' by the part that the rig has."""
    (slack,) = (each for each in off.rig if each.name == SLACK)
    assert slack.std == pytest.approx(0.1 / np.sqrt(2))
    assert np.isfinite(off.covariance).all()
    assert np.linalg.eigvalsh(off.covariance).min() > 0


@pytest.mark.parametrize(("found", "told"), [(0.08, 0.03), (0.01, 0.03)])
def test_a_new_coupon_may_differ_as_much_as_was_told_or_found(found: float, told: float) -> None:
    """Few coupons that happen to be alike do not make the next one like them."""
    scatter = Scatter(specimens=8, scale=found, prior_scale=told, shape=0.0, estimated=True)
    of = SimpleNamespace(
        errors=SimpleNamespace(scatter=scatter), closed_form=True,
        problem=SimpleNamespace(always=()),
    )  # fmt: skip
    readings = np.array([2.0, 5.0])
    others = Analysis.unfitted(of, {}, readings)  # type: ignore[arg-type]
    np.testing.assert_allclose(np.sqrt(np.diag(others)), max(0.03, found) * readings)

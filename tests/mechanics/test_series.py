"""A path's Taylor series: against the solutions near by, and where there is none."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from support import bodies
from support.paths import by_pressure

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.policy import SeriesPolicy
from dolfingrip.mechanics.path.predictor import InverseMap, taylor_reach, taylor_terms

EXACT = Solver(rtol=1e-14, atol_N=1e-14)
POLICY = SeriesPolicy()
UNIT_kPa = 200.0
APART = 0.1
"""Of the solutions that the series is held against, a part of the unit."""


@pytest.fixture
def solid() -> bodies.Body:
    """The hollow cube on its clamp, linear elements."""
    solid = bodies.body(bodies.hollow_cube(), 1)
    solid.hold(bodies.plane(2, 0.0))
    return solid


def at(solid: bodies.Body, pressure_kPa: float) -> np.ndarray:
    """The displacement at a pressure (mm), to the last digits."""
    solid.model.prescribe({"pressure_kPa": pressure_kPa})
    assert Newton(solid.model, EXACT).solve().converged
    return solid.u.x.array.copy()


def terms(solid: bodies.Body, rates: Mapping[str, float]) -> list[np.ndarray]:
    """The series at the present state."""
    newton = Newton(solid.model, EXACT)
    return taylor_terms(solid.model, newton.linear, solid.model.state().controls, rates, POLICY)


@pytest.mark.parametrize("start_kPa", [0.0, 120.0])
def test_terms_are_those_of_the_solutions(solid: bodies.Body, start_kPa: float) -> None:
    """Reference: the polynomial through solutions on either side, of twice the order."""
    steps = APART * np.arange(-3, 4)
    solutions = [at(solid, start_kPa + UNIT_kPa * step) for step in steps]
    expected = np.polynomial.polynomial.polyfit(steps, solutions, 6)
    here = at(solid, start_kPa)
    found = terms(solid, {"pressure_kPa": UNIT_kPa, "time_s": 1.0})
    assert len(found) == POLICY.order
    first = np.abs(expected[1]).max()
    for term, wanted in zip(found, expected[1:], strict=False):
        np.testing.assert_allclose(term, wanted, rtol=0, atol=3e-5 * first)
    assert np.abs(expected[3]).max() > 1e-3 * first
    # the model is left as it was
    np.testing.assert_array_equal(solid.u.x.array, here)
    assert solid.model.state().controls == {"pressure_kPa": start_kPa, "time_s": 0.0}


def test_a_path_that_does_not_move_has_none(solid: bodies.Body) -> None:
    """Time alone moves nothing elastic; no tangent is made for it."""

    def tangent() -> InverseMap:
        raise AssertionError

    controls = solid.model.state().controls
    assert taylor_terms(solid.model, tangent, controls, {"time_s": 1.0}, POLICY) == []


def test_a_touch_has_none() -> None:
    """Pressed on the plate's barrier, which stiffens at once, the cube's series does not fall."""
    solid = bodies.body(bodies.hollow_cube(), 1, barrier_mm=1e-4)
    solid.hold(bodies.plane(2, 0.0))
    solid.plate.offset.value = -5e-5
    assert Newton(solid.model, EXACT).solve().converged
    found = terms(solid, {"pressure_kPa": UNIT_kPa})
    assert taylor_reach(solid.model, found, POLICY.easy) < POLICY.nearest  # it is not used


def test_a_linear_body_arrives_at_once() -> None:
    """A step so small that third order suffices takes no second iteration."""
    solid = bodies.body(bodies.hollow_cube(), 1)
    solid.hold(bodies.plane(2, 0.0))
    path = by_pressure(Newton(solid.model, Solver(rtol=1e-8, max_step_kPa=10.0)))
    assert path.advance({"pressure_kPa": 10.0}).iterations <= 1

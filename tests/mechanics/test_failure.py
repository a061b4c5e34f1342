"""What happens beyond a limit point, and before an element turns inside out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from support import bodies, spheres
from support.paths import by_pressure

from dolfingrip.config import KPA, Solver
from dolfingrip.mechanics.newton.ending import Solve
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import Failure, FailureKind
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.mechanics.path.policy import PathPolicy

MU, LMBDA = 1.0, 9.0
"""MPa: of ``bodies.body`` at its Poisson's ratio of 0.45."""
SMALLEST_KPA = 0.2
"""Step at which a failure is called."""


@pytest.fixture(scope="module")
def sphere() -> bodies.Body:
    """The balloon of the folder's other tests, of half as many elements."""
    solid = bodies.body(spheres.octant(1.0, spheres.RATIO, 0.4), 2)
    spheres.hold_octant(solid)
    return solid


@pytest.fixture(scope="module")
def greatest_kPa() -> float:
    """Greatest pressure that the balloon can bear, from the radial equation."""

    def missing(stretch: float) -> float:
        return -spheres.pressure_MPa(stretch, MU, LMBDA)

    best = minimize_scalar(missing, bounds=(1.3, 1.8), method="bounded", options={"xatol": 1e-6})
    return float(-best.fun / KPA)


@pytest.fixture(scope="module", params=[50.0, 100.0])
def overloaded(
    request: pytest.FixtureRequest, sphere: bodies.Body, greatest_kPa: float
) -> Iterator[tuple[LoadPath, Failure]]:
    """The balloon pressurised beyond its limit point, in steps of at most so many kPa."""
    settings = Solver(
        rtol=1e-11, max_iterations=10, max_step_kPa=request.param, min_step_kPa=SMALLEST_KPA
    )
    path = by_pressure(Newton(sphere.model, settings))
    failure = path.advance({"pressure_kPa": 1.3 * greatest_kPa}).failure
    assert failure is not None
    print("greatest", greatest_kPa, failure.sentence())
    yield path, failure
    sphere.displace(np.zeros_like(sphere.nodes))
    sphere.model.prescribe({"pressure_kPa": 0.0, "time_s": 0.0})


def test_limit_point_is_called_that(overloaded: tuple[LoadPath, Failure]) -> None:
    """The maximum of p(stretch) is no want of iterations, whatever the length of the steps."""
    assert overloaded[1].kind is FailureKind.LIMIT_POINT


def test_balloon_stops_at_its_limit_point(
    overloaded: tuple[LoadPath, Failure], greatest_kPa: float
) -> None:
    """Pressure control ends at the maximum of p(stretch), from where the way back is open.

    The last step that failed is at most twice the smallest; the mesh adds 0.1 %.
    """
    path, failure = overloaded
    reached = failure.last_good["pressure_kPa"]
    assert reached == pytest.approx(greatest_kPa, abs=2 * SMALLEST_KPA + 1e-3 * reached)
    assert path.model.state().controls["pressure_kPa"] == pytest.approx(reached, rel=1e-12)
    assert path.advance({"pressure_kPa": 0.0}).failure is None
    assert np.abs(path.model.u.x.array).max() < 1e-9


def test_care_is_left_out_where_it_did_not_help(
    sphere: bodies.Body, greatest_kPa: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond the limit point the first step that fails is tried damped, and the last one."""
    settings = Solver(rtol=1e-11, max_iterations=10, max_step_kPa=100, min_step_kPa=SMALLEST_KPA)
    newton = Newton(sphere.model, settings)
    tried: list[tuple[bool, bool]] = []
    solve = newton.solve

    def record(*guess: Any, damped: bool = False, **given: Any) -> Solve:
        found = solve(*guess, damped=damped, **given)
        tried.append((damped, found.converged))
        return found

    monkeypatch.setattr(newton, "solve", record)
    path = by_pressure(newton)
    assert path.advance({"pressure_kPa": 0.5 * greatest_kPa}).failure is None
    tried.clear()
    arrival = path.advance({"pressure_kPa": 1.3 * greatest_kPa})
    sphere.displace(np.zeros_like(sphere.nodes))
    sphere.model.prescribe({"pressure_kPa": 0.0, "time_s": 0.0})
    assert arrival.failure is not None
    failed = [damped for damped, converged in tried if not converged]
    assert failed[:2] == [False, True]
    assert failed[-2:] == [False, True]
    assert failed.count(True) == 2
    assert failed.count(False) > 4


def test_running_away_is_a_limit_point(sphere: bodies.Body, greatest_kPa: float) -> None:
    """Also where the state before has not gone soft yet, as a step is too long to come close."""
    settings = Solver(rtol=1e-11, max_iterations=30, max_step_kPa=50, min_step_kPa=5)
    path = by_pressure(Newton(sphere.model, settings), policy=PathPolicy(soft=0.0))
    arrival = path.advance({"pressure_kPa": 1.3 * greatest_kPa})
    sphere.displace(np.zeros_like(sphere.nodes))
    sphere.model.prescribe({"pressure_kPa": 0.0, "time_s": 0.0})
    assert arrival.failure is not None
    assert arrival.failure.kind is FailureKind.LIMIT_POINT


@pytest.fixture(scope="module")
def tetrahedron() -> bodies.Body:
    """One linear element that stands on a held face."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 1]])
    solid = bodies.body(bodies.domain(bodies.tetrahedra(points, np.array([[0, 1, 2, 3]])), {}), 1)
    solid.hold(bodies.plane(2, 0.0))
    return solid


@pytest.mark.parametrize("way", [0.5, 1.0, 2.0, 20.0])
def test_inverting_step_is_cut(tetrahedron: bodies.Body, way: float) -> None:
    """A step that takes the apex down by ``way`` heights is cut until J is above a tenth.

    J = 1 − f·way for the fraction f of the step; f is 1 or halved until it is allowed.
    """
    tetrahedron.displace(np.zeros((4, 3)))
    step = np.where(np.isclose(tetrahedron.nodes[:, 2:], 1.0), [0, 0, -way], 0.0).ravel()
    fraction, reason = tetrahedron.model.admissible_step(step)
    assert not tetrahedron.u.x.array.any()  # it only looked
    assert 1 - fraction * way > 0.1
    if way == 0.5:
        assert (fraction, reason) == (1.0, "")
    else:
        assert reason == "inverted"
        assert 1 - 2 * fraction * way <= 0.1  # and cut no more than needed


def test_crushing_load_inverts_nothing(tetrahedron: bodies.Body) -> None:
    """A load whose first full step would invert the element is solved for with J > 0.

    The neo-Hookean energy goes to infinity as J → 0, so there is a solution to any weight.
    """
    tetrahedron.displace(np.zeros((4, 3)))
    tetrahedron.body_force.x.array[:] = np.tile([0, 0, -60.0], 4)
    apex = 3 * int(tetrahedron.nodes[:, 2].argmax()) + np.arange(3, dtype=np.int32)
    stiffness = tetrahedron.tangent().getValues(apex, apex)
    plain = np.linalg.solve(stiffness, -tetrahedron.gradient().ravel()[apex])
    assert 1 + plain[2] < 0  # J of the first full step

    solve = Newton(tetrahedron.model, Solver(rtol=1e-9, max_iterations=50)).solve()
    height = 1 + tetrahedron.displacement()[:, 2].min()
    print("height after the full step", 1 + plain[2], "at rest", height, solve)
    tetrahedron.body_force.x.array[:] = 0.0
    assert solve.converged
    # V ψ'(J) is a quarter of the weight, J being the height: F = diag(1, 1, J) and a shear
    expected = brentq(lambda j: MU * (j - 1 / j) + LMBDA * np.log(j) / j + 60.0 / 4, 0.01, 1.0)
    assert height == pytest.approx(expected, rel=1e-8)
    assert tetrahedron.model.potential.smallest_jacobian() == pytest.approx(height)


def test_wild_step_leaves_no_nan(tetrahedron: bodies.Body) -> None:
    """Too few iterations under that load fail, but with finite numbers and J > 0."""
    tetrahedron.displace(np.zeros((4, 3)))
    tetrahedron.body_force.x.array[:] = np.tile([0, 0, -1e6], 4)
    solve = Newton(tetrahedron.model, Solver(max_iterations=3)).solve()
    tetrahedron.body_force.x.array[:] = 0.0
    assert not solve.converged
    assert np.isfinite(tetrahedron.gradient()).all()
    assert np.isfinite(tetrahedron.displacement()).all()
    assert tetrahedron.model.potential.smallest_jacobian() > 0.0

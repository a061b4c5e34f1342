"""When terms update what they hold, and Newton's method with them."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies

from dolfingrip.config import Solver
from dolfingrip.mechanics.model.term import Lagged, LaggedCorrection, Term
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.ending import Ending
from dolfingrip.mechanics.newton.lagging import LagRules
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.policy import LagPolicy

POLICY = LagPolicy()


class Lagging(Term, Lagged):
    """A force on the top along x that is a share of its displacement, held meanwhile."""

    def __init__(self, top: np.ndarray, share: float, restless: float = 0.0) -> None:
        self._top, self._share, self._restless = top, share, restless
        self.force = 0.0
        self.times = 0

    def _now(self, dofs: np.ndarray) -> float:
        return float(self._share * dofs.reshape(-1, 3)[self._top, 0].mean())

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        gradient.at_nodes[self._top, 0] -= (self.force + 0.01) / len(self._top)

    def update_lagged(self, dofs: np.ndarray) -> bool:
        self.times += 1
        self.force = self._now(dofs) + self._restless * (-1) ** self.times
        return True

    def lag_error(self, dofs: np.ndarray) -> float:
        now = self._now(dofs)
        return abs(self.force - now) / max(abs(now), 1e-9)

    def lagged_correction(self, dofs: np.ndarray) -> LaggedCorrection | None:
        return None

    def lagged_state(self) -> float:
        return self.force

    def restore_lagged(self, state: float) -> None:
        self.force = state


def pulled(share: float, restless: float = 0.0) -> tuple[bodies.Body, Lagging, Newton]:
    cube = bodies.body(bodies.domain(bodies.box((2, 2, 2)), {}), 1, nu=0.3)
    cube.hold(bodies.plane(2, 0.0))
    top = np.flatnonzero(np.isclose(cube.nodes[:, 2], 1.0))
    term = Lagging(top, share, restless)
    cube.model.terms = [cube.plate, term]
    return cube, term, Newton(cube.model, Solver(rtol=1e-9, atol_N=1e-12, max_iterations=40))


def test_what_is_held_ends_as_that_of_the_solution() -> None:
    """A share s of the stiffness K = F/u without it: u grows by 1/(1 − s)."""
    cube, _, newton = pulled(0.0)
    assert newton.solve().converged
    top = np.isclose(cube.nodes[:, 2], 1.0)
    alone = cube.displacement()[top, 0].mean()
    stiffness = 0.01 / alone
    cube, term, newton = pulled(0.3 * stiffness)
    solve = newton.solve()
    assert solve.converged
    assert term.lag_error(cube.u.x.array) <= POLICY.tolerance
    assert 0 < term.times < solve.iterations
    assert cube.displacement()[top, 0].mean() == pytest.approx(alone / 0.7, rel=POLICY.tolerance)


def test_what_never_settles_is_no_solution() -> None:
    _, term, newton = pulled(0.1, restless=1e-3)
    solve = newton.solve()
    assert solve.ending in (Ending.DIVERGED, Ending.ITERATIONS)
    assert term.times > POLICY.again


def test_steps_are_followed_until_one_overshoots() -> None:
    cube, _, _ = pulled(0.0)
    rules = LagRules(cube.model, POLICY)
    assert not rules.is_due(1.0, 1.0)
    assert rules.current  # nothing is held that drifts
    for norm in (5.0, 6.0, 9.0):  # as a step that turns much makes it rise
        rules.corrected = True
        assert rules.is_due(norm, 1.0)
        assert rules.current
        rules.updated(norm)
    rules.corrected = True
    assert not rules.is_due(POLICY.overshot * 9.1, 1.0)
    assert rules.is_due(4.0, 1.0)
    assert not rules.current
    rules = LagRules(cube.model, POLICY, predicted=True)
    assert rules.is_due(1.0, 1.0)
    assert rules.current
    rules.updated(0.9)
    rules.corrected = True
    assert rules.is_due(5e-4, 1.0)
    assert not rules.current  # close to the solution


def test_an_overshoot_is_not_followed() -> None:
    cube, _, _ = pulled(0.0)
    rules = LagRules(cube.model, POLICY)
    assert not rules.is_due(1.0, 1.0)  # where the load step starts
    assert not rules.is_due(3.0, 1.0)
    assert rules.is_due(0.4, 1.0)
    rules.updated(0.6)
    assert not rules.is_due(0.35, 1.0)
    assert rules.is_due(0.25, 1.0)
    rules.updated(0.3)
    assert rules.is_due(2e-3, 1.0)  # close to the solution: the last time
    rules.updated(2.5e-3)
    assert not rules.is_due(1e-4, 1.0)
    rules = LagRules(cube.model, POLICY)
    assert rules.is_due(0.2, 1.0)  # a start that was predicted well


class Astray(Lagging):
    """Its force grows tenfold with each update, until Newton's method goes back to the start."""

    def __init__(self, top: np.ndarray) -> None:
        super().__init__(top, 0.1)
        self.restored: list[float] = []
        self.corrections: list[bool] = []

    def update_lagged(self, dofs: np.ndarray) -> bool:
        if self.restored:
            return super().update_lagged(dofs)
        self.times += 1
        self.force = 0.001 * 10.0**self.times
        return True

    def lagged_correction(self, dofs: np.ndarray) -> LaggedCorrection | None:
        """Asked for before each step along which lagged quantities are to change."""
        self.corrections.append(bool(self.restored))
        return None

    def restore_lagged(self, state: float) -> None:
        self.restored.append(state)
        super().restore_lagged(state)


def test_a_solve_that_goes_astray_starts_once_more() -> None:
    """From where it began, what terms hold included, and without what follows; once, or not."""
    solves = []
    for again in (True, False):
        cube, _, _ = pulled(0.1)
        held = Astray(np.flatnonzero(np.isclose(cube.nodes[:, 2], 1.0)))
        cube.model.terms = [cube.plate, held]
        newton = Newton(cube.model, Solver(rtol=1e-9, atol_N=1e-12, max_iterations=40))
        solves.append(newton.solve(again=again))
        assert held.corrections
        assert not any(held.corrections)  # after the second start none is asked for
        assert held.restored == ([0.0] if again else [])
    second, first = solves
    assert second.converged
    assert not first.converged
    calm = pulled(0.1)[2].solve()
    assert second.iterations == first.iterations + calm.iterations

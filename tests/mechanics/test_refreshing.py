"""When terms update what they hold, and Newton's method with them."""

from __future__ import annotations

import numpy as np
import pytest
from mechanics import bodies

from dolfingrip.config import Solver
from dolfingrip.mechanics.model.state import Guess
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.ending import Ending, Solve
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.refreshing import AGAIN, DRIFTS, OVERSHOT, Refreshing


class Following(Term):
    """A force on the top along x that is a share of its displacement, held meanwhile."""

    def __init__(self, top: np.ndarray, share: float, restless: float = 0.0) -> None:
        self._top, self._share, self._restless = top, share, restless
        self.force = 0.0
        self.times = 0

    def _now(self, dofs: np.ndarray) -> float:
        return float(self._share * dofs.reshape(-1, 3)[self._top, 0].mean())

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        gradient.at_nodes[self._top, 0] -= (self.force + 0.01) / len(self._top)

    def refresh(self, dofs: np.ndarray) -> bool:
        self.times += 1
        self.force = self._now(dofs) + self._restless * (-1) ** self.times
        return True

    def drift(self, dofs: np.ndarray) -> float:
        now = self._now(dofs)
        return abs(self.force - now) / max(abs(now), 1e-9)

    def held(self) -> float:
        return self.force

    def hold(self, held: float) -> None:
        self.force = held


def pulled(share: float, restless: float = 0.0) -> tuple[bodies.Body, Following, Newton]:
    cube = bodies.body(bodies.domain(bodies.box((2, 2, 2)), {}), 1, nu=0.3)
    cube.hold(bodies.plane(2, 0.0))
    top = np.flatnonzero(np.isclose(cube.nodes[:, 2], 1.0))
    term = Following(top, share, restless)
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
    assert term.drift(cube.u.x.array) <= DRIFTS
    assert 0 < term.times < solve.iterations
    assert cube.displacement()[top, 0].mean() == pytest.approx(alone / 0.7, rel=DRIFTS)


def test_what_never_settles_is_no_solution() -> None:
    _, term, newton = pulled(0.1, restless=1e-3)
    solve = newton.solve()
    assert solve.ending in (Ending.DIVERGED, Ending.ITERATIONS)
    assert term.times > AGAIN


def test_steps_are_followed_until_one_overshoots() -> None:
    cube, _, _ = pulled(0.0)
    rules = Refreshing(cube.model)
    assert not rules.follows(1.0, 1.0)
    assert rules.fresh  # nothing is held that drifts
    for norm in (5.0, 6.0, 9.0):  # as a step that turns much makes it rise
        rules.followed = True
        assert rules.follows(norm, 1.0)
        assert rules.fresh
        rules.done(norm)
    rules.followed = True
    assert not rules.follows(OVERSHOT * 9.1, 1.0)
    assert rules.follows(4.0, 1.0)
    assert not rules.fresh
    rules.start(predicted=True)
    assert rules.follows(1.0, 1.0)
    assert rules.fresh
    rules.done(0.9)
    rules.followed = True
    assert rules.follows(5e-4, 1.0)
    assert not rules.fresh  # close to the solution


def test_an_overshoot_is_not_followed() -> None:
    cube, _, _ = pulled(0.0)
    rules = Refreshing(cube.model)
    assert not rules.follows(1.0, 1.0)  # where the load step starts
    assert not rules.follows(3.0, 1.0)
    assert rules.follows(0.4, 1.0)
    rules.done(0.6)
    assert not rules.follows(0.35, 1.0)
    assert rules.follows(0.25, 1.0)
    rules.done(0.3)
    assert rules.follows(2e-3, 1.0)  # close to the solution: the last time
    rules.done(2.5e-3)
    assert not rules.follows(1e-4, 1.0)
    rules.start()
    assert rules.follows(0.2, 1.0)  # a start that was predicted well


def test_a_solve_that_was_led_astray_starts_once_more() -> None:
    """From where it began, what terms hold included, and without what follows; once, or not."""
    cube, term, newton = pulled(0.1)
    starts: list[tuple[bool, np.ndarray, float]] = []
    real = newton._iterate

    def astray(guess: Guess | None, *, damped: bool, following: bool = True) -> Solve:
        starts.append((following, cube.model.unknowns.local(), term.held()))
        if following:
            cube.u.x.array[:] += 0.3
            term.hold(7.0)
            newton._refreshing.overshot = True
            return Solve(Ending.DIVERGED, 5)
        return real(guess, damped=damped, following=following)

    newton._iterate = astray  # type: ignore[method-assign]
    solve = newton.solve()
    assert solve.converged
    assert [following for following, _, _ in starts] == [True, False]
    np.testing.assert_array_equal(starts[0][1], starts[1][1])
    assert starts[0][2] == starts[1][2]
    assert solve.iterations > 5
    starts.clear()
    assert not newton.solve(again=False).converged
    assert len(starts) == 1

"""Where a load step starts: exact for cubics, fewer iterations, the same solutions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support import bodies
from support.paths import by_pressure

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path import predictor
from dolfingrip.mechanics.path.policy import PathPolicy, PredictorPolicy

SEED = 5
SETTINGS = Solver(rtol=1e-10, max_step_kPa=40.0, min_step_kPa=5.0)
RISE = [40.0, 80.0, 120.0, 160.0, 200.0]
BETWEEN = [180.0, 140.0, 100.0, 60.0]


@pytest.fixture
def solid() -> bodies.Body:
    """The hollow cube on its clamp, linear elements."""
    solid = bodies.body(bodies.hollow_cube(), 1)
    solid.hold(bodies.plane(2, 0.0))
    return solid


@pytest.mark.parametrize("count", [3, 4])
def test_weights_are_exact(count: int) -> None:
    """A polynomial through all places is met at any place."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    places = np.cumsum(rng.uniform(0.2, 1.0, count))
    polynomial = np.polynomial.Polynomial(rng.uniform(-1, 1, count))
    ahead = places[-1] + 0.7
    weights = predictor.lagrange(places, ahead)
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ polynomial(places) == pytest.approx(polynomial(ahead), rel=1e-11)


def followed(
    solid: bodies.Body, pressures_kPa: list[float], policy: PathPolicy | None = None
) -> tuple[list[int], list[np.ndarray]]:
    """Iterations and displacements at each of the pressures, in turn."""
    path = by_pressure(Newton(solid.model, SETTINGS), policy=policy)
    iterations, displacements = [], []
    for pressure in pressures_kPa:
        arrival = path.advance({"pressure_kPa": pressure})
        assert arrival.failure is None
        assert arrival.steps == 1
        iterations.append(arrival.iterations)
        displacements.append(solid.model.u.x.array.copy())
    return iterations, displacements


def test_prediction_saves_iterations_and_changes_nothing_else(solid: bodies.Body) -> None:
    """At first the steps start from the path's series, then from the last states."""
    with_series, found = followed(solid, RISE)
    solid.displace(np.zeros_like(solid.nodes))
    solid.model.prescribe({"pressure_kPa": 0.0})
    never = PathPolicy(predictor=PredictorPolicy(fewest=99))
    plain, expected = followed(solid, RISE, never)
    assert max(with_series) < min(plain)
    assert sum(with_series) < 0.6 * sum(plain)
    for here, there in zip(found, expected, strict=True):
        np.testing.assert_allclose(here, there, atol=1e-8 * np.abs(there).max())


def test_a_turn_is_a_new_path(solid: bodies.Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its series the way back is not predicted from earlier states."""
    guessed: list[bool] = []
    plain = Newton.solve

    def solve(self: Newton, guess: predictor.Guess | None = None, **how: Any) -> object:
        guessed.append(guess is not None)
        return plain(self, guess, **how)

    monkeypatch.setattr(Newton, "solve", solve)
    followed(solid, [*RISE, *BETWEEN])
    assert all(guessed)
    guessed.clear()
    solid.displace(np.zeros_like(solid.nodes))
    solid.model.prescribe({"pressure_kPa": 0.0})
    monkeypatch.setattr(predictor, "taylor_terms", lambda *_: [])
    followed(solid, [*RISE, *BETWEEN])
    assert guessed == [False, False, True, True, True, False, False, True, True]


@pytest.mark.parametrize("jumps", [False, True])
def test_a_way_back_starts_from_the_states_of_the_way_there(
    solid: bodies.Body, *, jumps: bool
) -> None:
    """An elastic body was there already; after a step that moves it far it may not return there."""
    policy = PathPolicy(soft=10.0 if jumps else 0.2)  # 10: all steps count as jumps
    iterations, found = followed(solid, [*RISE, *RISE[-2::-1]], policy)
    back = iterations[len(RISE) :]
    assert all(back) if jumps else not any(back)
    for there, here in zip(found[3::-1], found[5:], strict=True):
        np.testing.assert_allclose(here, there, atol=1e-8 * np.abs(there).max())


def test_a_state_set_from_outside_is_a_new_path(solid: bodies.Body) -> None:
    """A path that is not where it had been left does not look back."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    rest = solid.model.state()
    for pressure in RISE[:3]:
        path.advance({"pressure_kPa": pressure})
    solid.model.restore(rest)
    arrival = path.advance({"pressure_kPa": 160.0})
    assert arrival.failure is None
    found = solid.model.u.x.array.copy()
    solid.model.restore(rest)
    assert (
        by_pressure(Newton(solid.model, SETTINGS)).advance({"pressure_kPa": 160.0}).failure is None
    )
    np.testing.assert_allclose(found, solid.model.u.x.array, atol=1e-8 * np.abs(found).max())

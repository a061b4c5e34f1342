"""The load path: where it lands, what it remembers, and that it comes back."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from support import bodies
from support.paths import by_pressure

from dolfingrip.config import KPA, Solver
from dolfingrip.mechanics.newton.ending import Ending, Solve
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import FailureKind
from dolfingrip.mechanics.path.policy import PathPolicy

SETTINGS = Solver(rtol=1e-11, max_step_kPa=40.0, min_step_kPa=5.0)


@pytest.fixture(scope="module")
def clamped() -> bodies.Body:
    """The hollow cube on its clamp, linear elements."""
    solid = bodies.body(bodies.hollow_cube(), 1)
    solid.hold(bodies.plane(2, 0.0))
    return solid


@pytest.fixture
def solid(clamped: bodies.Body) -> Iterator[bodies.Body]:
    """As ``clamped``, at rest before and after each test."""
    yield clamped
    clamped.displace(np.zeros_like(clamped.nodes))
    clamped.model.prescribe({"pressure_kPa": 0.0, "time_s": 0.0})


def test_a_way_that_is_a_sliver_of_a_step_is_one_step(solid: bodies.Body) -> None:
    """As a search for a pressure takes, where predictions do not hold over the longest step."""
    path = by_pressure(Newton(solid.model, Solver(rtol=1e-11, max_step_kPa=4000.0)))
    assert path.advance({"pressure_kPa": 400.0}).failure is None
    arrival = path.advance({"pressure_kPa": 400.0 + 1e-6})
    assert arrival.failure is None
    assert arrival.steps == 1


def test_lands_on_every_target(solid: bodies.Body) -> None:
    """Pressures and times are met exactly, in steps no longer than allowed."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    for pressure, time, steps in ((33.3, 1.1, 1), (100.1, 2.0, 2), (100.1, 7.0, 1), (0.7, 9.3, 3)):
        arrival = path.advance({"pressure_kPa": pressure, "time_s": time})
        assert arrival.failure is None
        assert arrival.steps == steps
        assert solid.pressure.value == pressure * KPA
        assert solid.model.time_s == time
        assert solid.model.state().controls == pytest.approx(
            {"pressure_kPa": pressure, "time_s": time}, rel=1e-15
        )


def test_it_ends_where_it_is_over(solid: bodies.Body) -> None:
    """After an accepted step, without a failure, and goes on from there."""
    highest = [50.0, 200.0]
    path = by_pressure(
        Newton(solid.model, SETTINGS), over=lambda: solid.pressure.value > highest[0] * KPA
    )
    arrival = path.advance({"pressure_kPa": 120.0})
    assert arrival.failure is None
    assert arrival.steps == 2
    assert solid.pressure.value == pytest.approx(80 * KPA)
    del highest[0]
    assert path.advance({"pressure_kPa": 120.0}).steps == 1
    assert solid.pressure.value == 120 * KPA


def test_intermediate_steps_lie_on_a_line(solid: bodies.Body) -> None:
    """All controls go together: time is the same share of its way as the pressure."""
    seen: list[tuple[float, float]] = []

    def record() -> str:
        controls = solid.model.state().controls
        seen.append((controls["pressure_kPa"], controls["time_s"]))
        return ""

    path = by_pressure(Newton(solid.model, SETTINGS), accept=record)
    path.advance({"pressure_kPa": 120.0, "time_s": 6.0})
    np.testing.assert_allclose(seen, [[40, 2], [80, 4], [120, 6]], rtol=1e-12)


def test_steps_double_again_after_easy_ones(solid: bodies.Body) -> None:
    """From the length at which a step was accepted, up to the longest."""
    seen: list[float] = []

    def accept() -> str:
        seen.append(solid.model.state().controls["pressure_kPa"])
        return "too long" if len(seen) <= 2 else ""

    path = by_pressure(Newton(solid.model, SETTINGS), accept=accept)
    assert path.advance({"pressure_kPa": 110.0}).failure is None
    np.testing.assert_allclose(seen, [40, 20, 10, 30, 70, 110], rtol=1e-12)


def test_a_damped_solve_starts_where_the_plain_one_did(solid: bodies.Body) -> None:
    newton = Newton(solid.model, SETTINGS)
    real, starts = newton.solve, []

    def solve(*args: Any, damped: bool = False, **kwargs: Any) -> Solve:
        starts.append((damped, solid.displacement(), solid.pressure.value.copy()))
        if len(starts) == 1:
            solid.u.x.array[:] += 0.1
            return Solve(Ending.DIVERGED, 3)
        return real(*args, damped=damped, **kwargs)

    newton.solve = solve  # type: ignore[method-assign]
    assert by_pressure(newton).advance({"pressure_kPa": 20.0}).failure is None
    (plain, *first), (damped, *second) = starts
    assert (plain, damped) == (False, True)
    np.testing.assert_array_equal(first[0], second[0])
    assert first[1] == second[1] == 20 * KPA


@pytest.mark.parametrize(("farther", "passes"), [(1.0, True), (30.0, False)])
def test_without_damping_small_jumps_alone_are_gone_over(
    solid: bodies.Body, farther: float, passes: bool
) -> None:
    """Where the load has a maximum, and a damped solve goes as far as a usual step or 30 times."""
    newton = Newton(solid.model, SETTINGS)
    real = newton.solve

    def solve(*args: Any, damped: bool = False, **kwargs: Any) -> Solve:
        if damped:
            found = real(*args, damped=True, **kwargs)
            solid.u.x.array[:] *= farther
            return found
        if solid.pressure.value > 60 * KPA:
            return Solve(Ending.DIVERGED, 3)
        return real(*args, **kwargs)

    newton.solve = solve  # type: ignore[method-assign]
    path = by_pressure(newton, damped=False, passable=lambda attempted: True)
    assert path.advance({"pressure_kPa": 40.0}).failure is None
    before = solid.displacement()
    failure = path.advance({"pressure_kPa": 80.0}).failure
    assert (failure is None) is passes
    if failure is not None:
        assert failure.kind is FailureKind.LIMIT_POINT
        np.testing.assert_array_equal(solid.displacement(), before)


def test_unloading_returns(solid: bodies.Body) -> None:
    """An elastic body forgets: after 200 kPa and back it is where it was, to 1e-9 mm."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    path.advance({"pressure_kPa": 200.0})
    assert np.abs(solid.displacement()).max() > 0.01
    path.advance({"pressure_kPa": 0.0})
    assert np.abs(solid.displacement()).max() < 1e-9


def test_state_is_a_copy(solid: bodies.Body) -> None:
    """A state neither follows the model nor shares memory with another, and restores it."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    path.advance({"pressure_kPa": 50.0, "time_s": 1.0})
    state = solid.model.state()
    other = solid.model.state()
    there = solid.displacement()
    path.advance({"pressure_kPa": 80.0, "time_s": 2.0})
    other.displacement[:] = 7.0
    other.controls["pressure_kPa"] = 7.0

    assert not np.array_equal(solid.displacement(), there)
    solid.model.restore(state)
    assert np.array_equal(solid.displacement(), there)
    assert solid.model.time_s == 1.0
    assert solid.pressure.value == pytest.approx(50.0 * KPA, rel=1e-15)


def test_path_does_not_depend_on_its_history(solid: bodies.Body) -> None:
    """Restored and loaded the same way again, the model reaches the same solution."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    path.advance({"pressure_kPa": 50.0})
    state = solid.model.state()
    path.advance({"pressure_kPa": 130.0})
    first = solid.displacement()
    solid.model.restore(state)
    path.advance({"pressure_kPa": 130.0})
    np.testing.assert_allclose(solid.displacement(), first, atol=1e-10)


def test_rejected_step_is_contact(solid: bodies.Body) -> None:
    """A state that must not be accepted is left, exactly; the step is halved down to its least."""

    rejected: list[float] = []

    def reject() -> str:
        pressure = solid.model.controls["pressure_kPa"].value
        if pressure < 60.0:
            return ""
        rejected.append(pressure)
        return "touches"

    path = by_pressure(Newton(solid.model, SETTINGS), accept=reject)
    assert path.advance({"pressure_kPa": 40.0, "time_s": 1.0}).failure is None
    arrival = path.advance({"pressure_kPa": 200.0, "time_s": 5.0})
    failure = arrival.failure
    assert failure is not None
    assert failure.kind is FailureKind.CONTACT
    assert rejected
    reached = failure.last_good["pressure_kPa"]
    assert 60.0 - 2 * SETTINGS.min_step_kPa <= reached < 60.0
    assert "kPa" in failure.sentence()

    left = solid.displacement()
    assert solid.model.controls["pressure_kPa"].value == pytest.approx(reached, rel=1e-12)
    # the state left is in equilibrium: another solve changes nothing
    assert Newton(solid.model, SETTINGS).solve().converged
    np.testing.assert_allclose(solid.displacement(), left, atol=1e-10)


def test_failed_step_is_undone_bitwise(solid: bodies.Body) -> None:
    """Too few iterations are called that, and the last good state is kept to the last bit."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    path.advance({"pressure_kPa": 50.0, "time_s": 2.0})
    good = solid.model.state()
    hasty = Solver(rtol=1e-30, atol_N=1e-30, max_step_kPa=40.0, min_step_kPa=5.0, max_iterations=1)
    failure = (
        by_pressure(Newton(solid.model, hasty))
        .advance({"pressure_kPa": 200.0, "time_s": 9.0})
        .failure
    )
    assert failure is not None
    assert failure.kind is FailureKind.ITERATION_LIMIT
    assert failure.last_good == pytest.approx({"pressure_kPa": 50.0, "time_s": 2.0})
    assert np.array_equal(solid.model.state().displacement, good.displacement)
    assert solid.model.state().controls == pytest.approx(good.controls)


def test_time_limit_ends_between_steps(solid: bodies.Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that goes on by 1 s a look: what was reached is kept, the rest is not tried."""
    ticks = itertools.count()
    monkeypatch.setattr("dolfingrip.mechanics.newton.iterations.is_late", lambda *_: False)
    monkeypatch.setattr("dolfingrip.mechanics.path.path.time.monotonic", lambda: float(next(ticks)))
    limited = SETTINGS.model_copy(update={"time_limit_s": 2.5})
    arrival = by_pressure(Newton(solid.model, limited)).advance({"pressure_kPa": 200.0})
    assert arrival.steps == 2
    failure = arrival.failure
    assert failure is not None
    assert failure.kind is FailureKind.TIME_LIMIT
    assert failure.last_good == pytest.approx({"pressure_kPa": 80.0})
    assert failure.sentence() == "stopped at 80 kPa (time limit)"


def test_time_limit_ends_within_a_solve(
    solid: bodies.Body, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A solve does not go on when the time is over; the state is the last good one."""
    path = by_pressure(Newton(solid.model, SETTINGS))
    path.advance({"pressure_kPa": 40.0})
    good = solid.model.state()
    monkeypatch.setattr("dolfingrip.mechanics.newton.iterations.is_late", lambda *_: True)
    arrival = path.advance({"pressure_kPa": 200.0})
    failure = arrival.failure
    assert failure is not None
    assert failure.kind is FailureKind.TIME_LIMIT
    assert failure.last_good == pytest.approx({"pressure_kPa": 40.0})
    assert arrival.steps == 0
    assert np.array_equal(solid.model.state().displacement, good.displacement)


@pytest.mark.parametrize("turns", [True, False])
def test_a_turn_that_is_foreseen_is_asked_for_before_a_step_is_tried(
    solid: bodies.Body, *, turns: bool
) -> None:
    """Once, at the last good state; the state in which it leaves the model is the last good one."""
    newton = Newton(solid.model, SETTINGS)
    real = newton.solve
    tried: list[tuple[bool, int | None]] = []
    asked_at: list[tuple[float, np.ndarray]] = []

    def solve(*args: Any, damped: bool = False, **kwargs: Any) -> Solve:
        tried.append((damped, kwargs.get("iterations")))
        if solid.pressure.value > 60 * KPA and not damped:
            return Solve(Ending.DIVERGED, 3)
        return real(*args, damped=damped, **kwargs)

    def passable(attempted: Mapping[str, float]) -> bool:
        asked_at.append((attempted["pressure_kPa"], solid.displacement()))
        if turns:
            solid.model.prescribe({"pressure_kPa": 57.0})
        return turns

    newton.solve = solve  # type: ignore[method-assign]
    path = by_pressure(newton, passable=passable, foreseen=lambda to: to["pressure_kPa"] > 50)
    assert path.advance({"pressure_kPa": 40.0}).failure is None
    before = solid.displacement()
    failure = path.advance({"pressure_kPa": 80.0}).failure
    assert asked_at[0][0] == 80
    np.testing.assert_array_equal(asked_at[0][1], before)
    if turns:
        assert failure is not None
        assert failure.kind is FailureKind.LIMIT_POINT
        assert failure.last_good == {"pressure_kPa": pytest.approx(57.0)}
        assert len(tried) == 1
    else:
        assert failure is None
        assert (False, None) in tried[1:]
        assert (True, None) in tried
    assert len(asked_at) == 1


def test_a_path_that_creeps_asks_whether_the_load_turns(solid: bodies.Body) -> None:
    """After a damped solve has failed and steps are short, and not before."""
    newton = Newton(solid.model, SETTINGS)
    real = newton.solve
    asked_at: list[float] = []

    def solve(*args: Any, **kwargs: Any) -> Solve:
        if solid.pressure.value > 61 * KPA:
            return Solve(Ending.DIVERGED, 3)
        return real(*args, **kwargs)

    def passable(attempted: Mapping[str, float]) -> bool:
        asked_at.append(attempted["pressure_kPa"])
        return True

    newton.solve = solve  # type: ignore[method-assign]
    policy = PathPolicy(creeping=0.3)
    path = by_pressure(newton, passable=passable, policy=policy)
    assert path.advance({"pressure_kPa": 40.0}).failure is None
    failure = path.advance({"pressure_kPa": 80.0}).failure
    assert failure is not None
    assert failure.kind is FailureKind.LIMIT_POINT
    assert failure.last_good == {"pressure_kPa": pytest.approx(60.0)}
    assert asked_at == [pytest.approx(70.0)]  # 80 and 70 fail, 60 holds, and then 70 is a fourth

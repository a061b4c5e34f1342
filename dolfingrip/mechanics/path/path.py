"""The load path: adaptive steps that end at the prescribed controls, up and down."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.newton.ending import Counts, Ending, Solve, is_late
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import Failure, FailureKind
from dolfingrip.mechanics.path.policy import PathPolicy
from dolfingrip.mechanics.path.predictor import Guess, Predictor

ERROR: Final = 0.08
"""Error of a prediction, relative to the step's displacement, that the next step aims at. Thin
walls need 3 or 4 iterations there, 6 at 0.12, 13 at 0.2."""

LEAST, MOST = 0.5, 2.0
"""Smallest and largest ratio of a step's length and that before."""

MARGIN: Final = 0.9
"""Part of the length at which a step's error in time would be the allowed one."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """The arrival at a target.

    Attributes:
        iterations: Newton iterations since the last target, also those of failed steps.
        steps: converged load steps.
        failure: why the target was not reached; the model is then at the last good state.
    """

    iterations: int
    steps: int
    failure: Failure | None = None


class _Leg:
    """The straight way to a target, and how far the model has come on it.

    Args:
        start, target: controls by name.
        length: of the way, in longest steps.
        counts: of the solver, as they are where the way begins.
        good: state there.

    Attributes:
        good: last good state.
        done: part of the way that leads to it.
        iterations: Newton iterations, also those of failed steps.
        steps: converged load steps.
        failure: why the target is not reached.
        over: whether nothing asks for the rest of the way.
    """

    def __init__(
        self,
        start: Mapping[str, float],
        target: Mapping[str, float],
        length: float,
        counts: Counts,
        good: State,
    ) -> None:
        self._start, self.target, self.length, self.good = start, target, length, good
        self.before = copy(counts)
        self.done, self.iterations, self.steps = 0.0, 0, 0
        self.failure: Failure | None = None
        self.over = False

    def at(self, part: float) -> dict[str, float]:
        """Controls after a part of the way."""
        if part == 1.0:
            return dict(self.target)
        start = self._start
        return {k: start[k] + part * (self.target[k] - start[k]) for k in self.target}


@dataclass(frozen=True, slots=True)
class _Step:
    """A step that is tried.

    Attributes:
        end: part of the way at which it ends.
        length: in longest steps.
        controls: at its end.
        guess: state that it starts from, if one is predicted.
        returns: whether that was a state of the path before.
        last: whether no shorter one is tried.
    """

    end: float
    length: float
    controls: dict[str, float]
    guess: Guess | None
    returns: bool
    last: bool


class Observer(Protocol):
    """An object that a path calls as it takes its steps."""

    def converged(self, before: State) -> None:
        """Called after a step from ``before`` has converged; must not change the model."""
        ...


class LoadPath:
    """Takes a model along straight lines between prescribed controls, time among them.

    A step starts from the state that the path so far predicts, as long as the path is straight. A
    step that fails is taken back and solved again with damping, and then halved. Steps grow again
    after easy ones. With damping the path may go on beyond a limit point, where the model snaps to
    another stable state. The solver's time limit counts from the path's creation and is checked
    before each step.

    Args:
        newton: solver of the model.
        longest: longest step of each control that limits the step; a control that is absent does
            not.
        accept: called after each converged step; returns a reason to reject it, or ""; default: the
            reasons of the model's terms.
        passable: called at the last good state with the controls that were not reached; returns
            whether equilibrium goes on there at a falling load. It may leave the model at the state
            of the greatest load, which is then the last good one.
        foreseen: called with a target, without damping with the controls of a step; returns whether
            the load is forecast to turn before them. Then ``passable`` is called before a step is
            tried, without damping after it was tried in few iterations.
        observers: called after each converged step, before it is accepted.
        over: called after each accepted step; if it returns true, the path ends there.
        damped: whether a failed step is solved again with damping, which may jump to another state.
            If not, only small jumps are taken, and ``passable`` is called where a step fails
            first: if it says yes and the jump is large, the path ends there at once. With damping
            it is called once, where a step fails that is short.
        policy: numbers behind its decisions.
    """

    def __init__(
        self,
        newton: Newton,
        longest: Mapping[str, float],
        accept: Callable[[], str] | None = None,
        passable: Callable[[Mapping[str, float]], bool] = lambda attempted: False,
        foreseen: Callable[[Mapping[str, float]], bool] = lambda attempted: False,
        observers: Sequence[Observer] = (),
        over: Callable[[], bool] = lambda: False,
        damped: bool = True,
        policy: PathPolicy | None = None,
    ) -> None:
        self.newton = newton
        self.model = newton.model
        settings = newton.settings
        self._longest = longest
        self._accept = accept or self.model.rejects
        self._passable, self._foreseen = passable, foreseen
        self._turns: bool | None = None  # whether the load falls before the target, if known
        self.observers = observers
        self._over = over
        self._damped = damped
        self._policy = policy = policy or PathPolicy()
        self._length = 1.0  # of the longest step
        self._waits, self._aside = False, 1.0  # that of waits while on a ramp, and the other way
        self._by_error = False  # whether the prediction's error tells the next one
        self._stiffest = 0.0
        self._shortest = settings.shortest_step
        self._end_s = time.monotonic() + (settings.time_limit_s or math.inf)
        self._predictor = Predictor(self.model, newton.linear, policy)
        self._lost = False  # whether the last damped solve towards this target failed
        self._direction: dict[str, float] = {}
        self._end: dict[str, float] = {}
        self._place = 0.0  # along the path, in longest steps

    def advance(self, target: Mapping[str, float]) -> Arrival:
        """Go to ``target`` (controls by name); end at the last good state on failure."""
        good = self.model.state()
        start = {name: good.controls[name] for name in target}
        self._keep_length(waits=all(start[k] == target[k] for k in self._longest if k in target))
        length = self._longest_steps(start, target)
        self._predictor.note(good)
        returned = self._predictor.noted({**good.controls, **target})
        if returned is None:
            self._turn(start, {name: (target[name] - start[name]) / length for name in target})
        leg = _Leg(start, target, length, self.newton.counts, good)
        self._lost, self._turns = False, None
        while leg.done < 1.0 and leg.failure is None and not leg.over:
            leg.failure = self._foretold(leg)
            if leg.failure is None:
                self._try(leg, self._begin(leg, returned))
            returned = None
        return Arrival(leg.iterations, leg.steps, leg.failure)

    def _keep_length(self, *, waits: bool) -> None:
        """Go on with the steps of the ramp before, after a wait, and the other way round."""
        if waits != self._waits:
            self._waits, self._length, self._aside = waits, self._aside, self._length

    def _foretold(self, leg: _Leg) -> Failure | None:
        """Why no further step is tried, where time is over or the load is known to turn."""
        if is_late(self.model.comm, self._end_s):
            return Failure(FailureKind.TIME_LIMIT, leg.at(leg.done))
        if self._damped and self._turns is None and self._foreseen(leg.target):
            self._turns = self._passable(leg.target)
        return self._failed(FailureKind.LIMIT_POINT, leg.target) if self._turns else None

    def _try(self, leg: _Leg, step: _Step) -> None:
        """Try a step, and take it, or go back and shorten the next one, or end the way."""
        solve = self._solve(leg.good, step)
        leg.iterations = self.newton.counts.iterations - leg.before.iterations
        rejected = self._accept() if solve.converged else ""
        if not solve.converged or rejected:
            leg.failure = self._taken_back(leg, step, solve, rejected)
            return
        error = self.model.step_error()
        if error > 1 and not step.last:
            self.model.restore(leg.good)
            self._shorten(step.length * _by_error(error))
        else:
            self._take(leg, step, solve.iterations, error)

    def _take(self, leg: _Leg, step: _Step, iterations: int, error: float) -> None:
        """Accept a converged step of some iterations, with an error in time by the allowed one."""
        stiffness = self._stiffness(step.length, leg.good)
        self._stiffest = max(self._stiffest, stiffness)
        jumped = 0 < stiffness < self._policy.soft * self._stiffest
        if jumped or self.newton.counts.damped > leg.before.damped:
            self._predictor.forget()
        self._adapt(step.length, step.guess, iterations, leg.good)
        if error:
            self._length = min(self._length, step.length * _by_error(error))
        leg.done, leg.steps = step.end, leg.steps + 1
        for observer in self.observers:
            observer.converged(leg.good)
        self.model.accept_step()
        self._place, self._end = self._place + step.length, {} if step.returns else step.controls
        if iterations > self._policy.comfortable:
            self._predictor.restart(self._place)
        else:
            self._predictor.keep(self._place)
        leg.good, leg.over = self.model.state(), self._over()

    def _taken_back(self, leg: _Leg, step: _Step, solve: Solve, rejected: str) -> Failure | None:
        """Go back from a failed step; return why the way ends there, if no shorter one is left."""
        if solve.ending is Ending.LATE:
            self.model.restore(leg.good)
            return Failure(FailureKind.TIME_LIMIT, leg.at(leg.done))
        away = solve.unstable and self._runs_away(step.length, leg.good)
        self.model.restore(leg.good)
        if self._turns is None and self._may_turn(step.length):
            self._turns = self._passable(step.controls)
        if self._turns:
            return self._failed(FailureKind.LIMIT_POINT, leg.target)
        self._shorten(step.length / 2)
        if self._length >= self._shortest:
            return None
        back = self._shortest / leg.length / 2
        soft = (
            away
            or self._is_soft(leg.at(leg.done - back), back * leg.length, leg.good)
            or ((self._turns is None or self._damped) and self._passable(step.controls))
        )
        return self._failed(_classify(solve, rejected, soft), leg.target)

    def _shorten(self, length: float) -> None:
        """Have the next step start anew from the last good state, with a length."""
        self._predictor.restart(self._place)
        self._length = length

    def _failed(self, kind: FailureKind, target: Mapping[str, float]) -> Failure:
        """The failure on the way to a target, in the present state."""
        here = self.model.state().controls
        return Failure(kind, {name: here[name] for name in target})

    def _may_turn(self, length: float) -> bool:
        """Return whether it is worth asking if the load turns where a step has failed."""
        creeps = self._lost and length < self._policy.creeping
        return not self._damped or creeps

    def _begin(self, leg: _Leg, returned: Guess | None) -> _Step:
        """Prescribe the controls of the next step, the whole way where its end is ``returned``."""
        end = 1.0 if returned else self._reach(leg.done, leg.length)
        length, controls = (end - leg.done) * leg.length, leg.at(end)
        self.model.prescribe(controls)
        guess = returned or self._predictor.guess(self._place + length)
        last = length < 2 * self._shortest
        return _Step(end, length, controls, guess, returns=returned is not None, last=last)

    def _reach(self, done: float, distance: float) -> float:
        """The part of a way of ``distance`` longest steps at which the next step ends."""
        length, remaining = min(self._length, 1.0) / distance, 1.0 - done
        if self._by_error:  # equal steps: a short last one would cost as much as a long one
            count = math.ceil(remaining / length - self._policy.sliver)
            length = remaining / max(count, 1)  # none of a way that is a sliver of a step
        # no tiny last step is left
        return 1.0 if (1 + self._policy.sliver) * length >= remaining else done + length

    def _adapt(self, taken: float, guess: Guess | None, iterations: int, before: State) -> None:
        """Choose the next step's length after a step of length ``taken`` has converged.

        Where the path's series did not hold over the longest step, the error of each prediction
        tells how far the next one holds (den Heijer & Rheinboldt, SIAM J. Numer. Anal. 18, 1981).
        """
        if self._by_error and guess is not None:
            now = self.model.u.x.array
            off = self._norm(self.model.unknowns.parts(guess.unknowns)[0] - now)
            aim = ERROR * self._norm(now - before.displacement)
            factor = (aim / off) ** (1 / 3) if off > 0 else MOST  # of a cubic
            wanted = taken * min(max(factor, LEAST), MOST)
            self._length = min(wanted if factor < 1 else max(wanted, self._length), 1.0)
        elif iterations <= self._policy.comfortable:
            self._length = min(2 * self._length, 1.0)

    def _longest_steps(self, start: Mapping[str, float], target: Mapping[str, float]) -> float:
        """Number of longest steps from ``start`` to ``target``; 1 if no control limits them."""
        distances = [
            abs(target[name] - start[name]) / longest
            for name, longest in self._longest.items()
            if name in target
        ]
        return max(distances, default=1.0) or 1.0

    def _solve(self, good: State, step: _Step) -> Solve:
        """Solve the model from ``good``, its state, at the controls of a step, its own.

        A step that fails is solved again with damping. If damping has not helped towards this
        target it is left out, except for the last step that is tried: beyond a limit point a
        damped solve takes many iterations to run away. A path without jumps tries it once, and
        takes what it finds only where the model changes little, as where one fold of many touches
        the next.
        """
        before = None
        if self._policy.from_equilibrium:
            before = {name: good.controls[name] for name in self.model.controls}
        asks = self._turns is None and self._foreseen(step.controls)
        again = not asks and (step.last or not self._policy.halves_first)
        few = self._policy.foreseen if asks else None
        solve = self.newton.solve(
            step.guess, before=before, again=again, iterations=few, end_s=self._end_s
        )
        gives_up = (self._lost or self._policy.halves_first) and not (step.last and self._damped)
        if solve.converged or gives_up or asks:
            return solve
        self.model.restore(good)
        self.model.prescribe(step.controls)
        damped = self.newton.solve(
            damped=True,
            iterations=None if self._damped else self._policy.small_jump,
            end_s=self._end_s,
        )
        if damped.converged and not self._damped:
            self._lost = self._stiffness(step.length, good) < self._policy.soft * self._stiffest
            return solve if self._lost else damped
        self._lost = not damped.converged
        return damped

    def _turn(self, start: dict[str, float], direction: dict[str, float]) -> None:
        """Set ``direction``, the change of each control in a longest step, from ``start`` on."""
        straight = start == self._end and all(
            math.isclose(change, self._direction[name], rel_tol=1e-6, abs_tol=1e-12)
            for name, change in direction.items()
        )
        if not straight:
            with self.newton.profile.phase("prediction"):
                easy = self._predictor.turn(self._place, direction)
            self._by_error = easy < 1.0
            self._length = min(self._length, easy)
        self._direction = direction

    def _stiffness(self, length: float, before: State) -> float:
        """Parts of a longest step for a change of the displacement by 1 mm from ``before``."""
        moved = self._norm(self.model.u.x.array - before.displacement)
        return length / moved if moved > 0 else 0.0

    def _norm(self, dofs: np.ndarray) -> float:
        """Norm of a local array of the displacement (mm), ghosts included."""
        return math.sqrt(self.model.comm.allreduce(float(dofs @ dofs), MPI.SUM))

    def _runs_away(self, length: float, good: State) -> bool:
        """Return whether a failed solve of a small step has gone far from ``good``.

        A motion through a viscous medium that finds no other stable state inverts elements or
        exceeds its iterations.
        """
        return self._stiffness(length, good) < self._policy.away * self._stiffest

    def _is_soft(self, controls: Mapping[str, float], length: float, good: State) -> bool:
        """Return whether a small step back is far softer than the stiffest of the path.

        It is Bergan's current stiffness parameter (Bergan, Horrigmoe, Kråkeland & Søreide, Int. J.
        Numer. Methods Eng. 12, 1978), which vanishes at a limit point. The pivots of a diverged
        iteration have no meaning. The model is restored to ``good``.
        """
        self.model.prescribe(controls)
        converged = self.newton.solve().converged
        stiffness = self._stiffness(length, good)
        self.model.restore(good)
        return converged and 0 < stiffness < self._policy.soft * self._stiffest


def _classify(solve: Solve, rejected: str, soft: bool) -> FailureKind:
    """The class of a step that failed at its smallest length."""
    if rejected or solve.ending is Ending.BLOCKED:
        return FailureKind.CONTACT
    if soft or solve.ending is Ending.SINGULAR:
        return FailureKind.LIMIT_POINT
    if solve.ending is Ending.INVERTED:
        return FailureKind.INVERTED_ELEMENT
    return FailureKind.ITERATION_LIMIT


def _by_error(error: float) -> float:
    """Ratio of the next step's length to that of a step with an error in time, by the allowed one.

    The error grows with the third power of the length.
    """
    return min(max(MARGIN * error ** (-1 / 3), LEAST), MOST)

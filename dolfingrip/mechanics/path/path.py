"""The load path: adaptive steps that end at the prescribed controls, up and down."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.newton.ending import Ending, Solve, is_late
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
        distance = self._longest_steps(start, target)

        def at(fraction: float) -> dict[str, float]:
            if fraction == 1.0:
                return dict(target)
            return {k: start[k] + fraction * (target[k] - start[k]) for k in target}

        self._predictor.note(good)
        noted = self._predictor.noted({**good.controls, **target})
        if noted is None:
            self._turn(start, {name: (target[name] - start[name]) / distance for name in target})
        self._lost, self._turns = False, None
        before, damped = self.newton.counts.iterations, self.newton.counts.damped
        done, iterations, steps = 0.0, 0, 0
        while done < 1.0:
            if is_late(self.model.comm, self._end_s):
                failure = Failure(FailureKind.TIME_LIMIT, at(done))
                return Arrival(iterations, steps, failure)
            reach = 1.0 if noted else self._next(done, distance)
            if self._damped and self._turns is None and self._foreseen(target):
                self._turns = self._passable(target)
                if self._turns:
                    failure = self._failed(FailureKind.LIMIT_POINT, target)
                    return Arrival(iterations, steps, failure)
            self.model.prescribe(at(reach))
            ahead = self._place + (reach - done) * distance
            guess, returns, noted = noted or self._predictor.guess(ahead), noted is not None, None
            taken = (reach - done) * distance
            last = taken < 2 * self._shortest
            solve = self._solve(good, at(reach), guess, taken, last=last)
            iterations = self.newton.counts.iterations - before
            rejected = self._accept() if solve.converged else ""
            error = self.model.step_error() if solve.converged and not rejected else 0.0
            if error > 1 and not last:
                self.model.restore(good)
                self._predictor.restart(self._place)
                self._length = taken * _by_error(error)
                continue
            if solve.converged and not rejected:
                stiffness = self._stiffness(taken, good)
                self._stiffest = max(self._stiffest, stiffness)
                jumped = 0 < stiffness < self._policy.soft * self._stiffest
                if jumped or self.newton.counts.damped > damped:
                    self._predictor.forget()
                self._adapt(taken, guess, solve.iterations, good)
                if error:
                    longest = taken * _by_error(error)
                    self._length = min(self._length, longest)
                done, steps = reach, steps + 1
                for observer in self.observers:
                    observer.converged(good)
                self.model.accept_step()
                self._place, self._end = ahead, {} if returns else at(reach)
                if solve.iterations > self._policy.comfortable:
                    self._predictor.restart(ahead)
                else:
                    self._predictor.keep(ahead)
                good = self.model.state()
                if self._over():
                    break
                continue
            if solve.ending is Ending.LATE:
                self.model.restore(good)
                return Arrival(iterations, steps, Failure(FailureKind.TIME_LIMIT, at(done)))
            away = solve.unstable and self._runs_away(taken, good)
            self.model.restore(good)
            if self._turns is None and self._may_turn(taken):
                self._turns = self._passable(at(reach))
            if self._turns:
                return Arrival(iterations, steps, self._failed(FailureKind.LIMIT_POINT, target))
            self._predictor.restart(self._place)
            self._length = taken / 2
            if self._length < self._shortest:
                back = self._shortest / distance / 2
                soft = (
                    away
                    or self._is_soft(at(done - back), back * distance, good)
                    or ((self._turns is None or self._damped) and self._passable(at(reach)))
                )
                kind = _classify(solve, rejected, soft)
                return Arrival(iterations, steps, self._failed(kind, target))
        return Arrival(iterations, steps)

    def _failed(self, kind: FailureKind, target: Mapping[str, float]) -> Failure:
        """The failure on the way to a target, in the present state."""
        here = self.model.state().controls
        return Failure(kind, {name: here[name] for name in target})

    def _may_turn(self, length: float) -> bool:
        """Return whether it is worth asking if the load turns where a step has failed."""
        creeps = self._lost and length < self._policy.creeping
        return not self._damped or creeps

    def _next(self, done: float, distance: float) -> float:
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

    def _solve(
        self,
        good: State,
        controls: Mapping[str, float],
        guess: Guess | None,
        length: float,
        *,
        last: bool,
    ) -> Solve:
        """Solve the model from ``good``, its state, at ``controls``, its own, a ``length`` away.

        A step that fails is solved again with damping. If damping has not helped towards this
        target it is left out, except for the ``last`` step that is tried: beyond a limit point a
        damped solve takes many iterations to run away. A path without jumps tries it once, and
        takes what it finds only where the model changes little, as where one fold of many touches
        the next.
        """
        before = None
        if self._policy.from_equilibrium:
            before = {name: good.controls[name] for name in self.model.controls}
        asks = self._turns is None and self._foreseen(controls)
        again = not asks and (last or not self._policy.halves_first)
        few = self._policy.foreseen if asks else None
        solve = self.newton.solve(
            guess, before=before, again=again, iterations=few, end_s=self._end_s
        )
        gives_up = (self._lost or self._policy.halves_first) and not (last and self._damped)
        if solve.converged or gives_up or asks:
            return solve
        self.model.restore(good)
        self.model.prescribe(controls)
        damped = self.newton.solve(
            damped=True,
            iterations=None if self._damped else self._policy.small_jump,
            end_s=self._end_s,
        )
        if damped.converged and not self._damped:
            self._lost = self._stiffness(length, good) < self._policy.soft * self._stiffest
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

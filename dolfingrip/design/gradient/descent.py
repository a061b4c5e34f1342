"""Steps from design to design, each accepted on what finite elements say.

A sequential quadratic programme in a trust region: the objective is a quadratic whose curvature is
learnt from gradients (damped BFGS; Nocedal & Wright, Numerical Optimization, 2006, procedure 18.2),
limits of simulated quantities are linear with a bend that is learnt from what they turned out to
be, and limits of the unloaded shape are kept exactly by linearising them anew until they hold. A
solve that fails, or a step that does not improve, makes the next step shorter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.design.gradient.evaluation import DesignNumbers, DesignSimulations
from dolfingrip.design.gradient.problem import Constraint, Floats, Problem, Scaling
from dolfingrip.design.gradient.shape import UnloadedShape, UnloadedShapes
from dolfingrip.design.gradient.subproblem import (
    DescentPolicy,
    ObjectiveModel,
    Rows,
    ShapeLimits,
    best_step,
    size_of,
)


@dataclass(slots=True)
class Trial:
    """A design that was simulated.

    Attributes:
        scaled: shape (variables,), 0 to 1 over their ranges.
        values: of the variables.
        shape: of the unloaded finger.
        simulations: load paths so far, with this one's.
        objective: the worst condition's; NaN where it failed.
        excess: by how much the worst simulated limit is broken, as a part of its size; 0 if kept.
        limits: value of each limit's quantity in its worst condition.
        accepted: whether the next steps begin here.
        radius: of the box that the step was chosen in.
        expected: gain of the objective that the model promised, in its unit.
        failure: class and sentence; "" if it was simulated.
        signed: shape (conditions,), objectives, which count as minimised.
        signed_slopes: shape (conditions, variables), by the scaled variables.
        of_parts: shape (variables, variables), the curvature of the worst condition's objective
            where it is a sum of squares of linear parts; None: it is no sum of squares.
        above: shape (m,), by how much simulated limits are broken, as parts of their sizes, for
            each limit and condition.
        above_slopes: shape (m, variables), likewise.
    """

    scaled: Floats
    values: Floats
    shape: UnloadedShape
    simulations: int
    objective: float = float("nan")
    excess: float = 0.0
    limits: list[float] = field(default_factory=list)
    accepted: bool = False
    radius: float = 0.0
    expected: float = 0.0
    failure: str = ""
    signed: Floats = field(default_factory=lambda: np.empty(0), repr=False)
    signed_slopes: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    of_parts: Floats | None = field(default=None, repr=False)
    above: Floats = field(default_factory=lambda: np.empty(0), repr=False)
    above_slopes: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)


@dataclass(slots=True)
class Descent:
    """The way that a descent took.

    Attributes:
        trials: every design that was simulated, in order; the first is the start.
        best: the last accepted one.
        ending: why it ended, in words.
        limits: the limits with their values.
        simulations: load paths that were followed.
        seconds: that they took in all.
    """

    trials: list[Trial]
    best: Trial
    ending: str
    limits: list[tuple[Constraint, float]]
    simulations: int
    seconds: float

    @property
    def start(self) -> Trial:
        """The design at which it began."""
        return self.trials[0]


Say = Callable[[Trial, Sequence[tuple[Constraint, float]]], None]
"""Called with each design that was simulated, and the limits with their values."""


def say_nothing(trial: Trial, limits: Sequence[tuple[Constraint, float]]) -> None:
    """Say nothing of a design."""


class NoStart(ConfigError):
    """The start cannot be simulated, or no design keeps the limits."""


class TrustRegionSQP:
    """Looks for the best design of a problem.

    Args:
        problem: to be solved.
        simulations: of its designs.
        say: called with each design that was simulated.
        policy: how steps are chosen and judged.
    """

    def __init__(
        self,
        problem: Problem,
        simulations: DesignSimulations,
        say: Say = say_nothing,
        policy: DescentPolicy = DescentPolicy(),
    ) -> None:
        self._problem, self._simulations, self._say = problem, simulations, say
        self._policy = policy
        self._shapes = UnloadedShapes(problem)
        self._scaling = Scaling(problem.variables)
        self._range = self._scaling.size
        self._spent, self._seconds = 0, 0.0
        self._limit: list[float] = []

    # -- the whole -------------------------------------------------------------------------------

    def run(self, begin: Floats | None = None) -> Descent:
        """Descend.

        Args:
            begin: shape (variables,), scaled values to begin at; default: the problem's start, of
                which limits count that were asked for as the start's.

        Raises:
            NoStart: one line.
        """
        problem = self._problem
        scaled = self._scaling.start
        self._spent, self._seconds = 0, 0.0
        if not self._limit:
            given = self._shapes.at(self._values(scaled))
            self._limit = [
                given.value(limit.quantity.name)
                if limit.limit is None and limit.quantity.experiment is None
                else (float("nan") if limit.limit is None else limit.limit)
                for limit in problem.limits
            ]
        here = self._simulated(self._into_limits(scaled if begin is None else begin))
        if here.failure:
            raise NoStart(f"the start cannot be simulated: {here.failure}")
        here.accepted = True
        self._tell(here)
        trials, n = [here], len(scaled)
        radius = problem.method.radius
        bend: Floats = np.zeros(len(here.above))
        curvature, fresh = np.eye(n) * self._policy.enough * abs(here.signed).max(), True
        ending = "the largest number of simulations is reached"
        cost = self._spent
        while self._spent + cost <= problem.method.simulations:
            worst = int(here.signed.argmax())
            if here.of_parts is not None:  # a sum of squares: Gauss and Newton's
                size = float(np.trace(here.of_parts)) / n
                curvature = here.of_parts + self._policy.ridge * size * np.eye(n)
            model = ObjectiveModel(here.signed, here.signed_slopes, curvature)
            rows = bundle(here, trials, bend, self._policy.bundle)
            proposal = self._step(here, model, rows, radius)
            if proposal is None:
                radius *= self._policy.failed
                if radius < self._policy.least_radius:
                    ending = "no shorter step keeps the limits of the shape"
                    break
                continue
            step, expected = proposal
            kept = here.excess <= self._policy.broken
            if kept and expected < self._policy.enough * abs(float(here.signed.max())):
                ending = "no step promises more"
                break
            trial = self._simulated(self._rounded(here.scaled + step))
            trial.radius, trial.expected = radius, expected
            trials.append(trial)
            if trial.failure:
                self._tell(trial)
                radius = self._policy.failed * float(np.abs(step).max())
            else:
                step = trial.scaled - here.scaled
                off = trial.above - predicted_limits(
                    bundle(here, trials[:-1], 0.0 * bend, self._policy.bundle), step, len(bend)
                )
                bend = np.where(off > 0, 2 * off / float(step @ step), 0.5 * bend)
                turn = trial.signed_slopes[worst] - here.signed_slopes[worst]
                curvature, fresh = bfgs_update(curvature, step, turn, fresh=fresh), False
                gain = float(here.signed.max() - trial.signed.max())
                if kept:
                    trial.accepted = trial.excess <= self._policy.broken and gain > 0
                else:
                    trial.accepted = trial.excess < here.excess
                self._tell(trial)
                radius = self._next_radius(trial, step, gain, expected, kept=kept)
                if trial.accepted:
                    here = trial
            if radius < self._policy.least_radius:
                ending = "no shorter step improves"
                if trial.failure:
                    ending = f"not known whether a step improves: it fails ({trial.failure})"
                break
        return Descent(trials, here, ending, self._limits(), self._spent, self._seconds)

    def _next_radius(
        self, trial: Trial, step: Floats, gain: float, expected: float, *, kept: bool
    ) -> float:
        """The radius after a step that was simulated."""
        reach = float(np.abs(step).max())
        if not trial.accepted:
            return self._policy.rejected * reach
        ratio = gain / expected if kept and expected > 0 else self._policy.good
        if ratio < self._policy.poor:
            return 0.5 * reach
        if ratio >= self._policy.good and reach > 0.9 * trial.radius:
            return min(2 * trial.radius, self._policy.largest_radius)
        return trial.radius

    def _tell(self, trial: Trial) -> None:
        self._say(trial, self._limits())

    def _limits(self) -> list[tuple[Constraint, float]]:
        return list(zip(self._problem.limits, self._limit, strict=True))

    # -- designs ---------------------------------------------------------------------------------

    def _rounded(self, scaled: Floats) -> Floats:
        return np.asarray(np.round(np.clip(scaled, 0.0, 1.0), self._policy.digits), dtype=float)

    def _values(self, scaled: Floats) -> Floats:
        return self._scaling.values(scaled, self._policy.digits - 2)

    def _simulated(self, scaled: Floats) -> Trial:
        values = self._values(scaled)
        shape = self._shapes.at(values)
        numbers = self._simulations.at(values)
        self._spent += numbers.simulations
        self._seconds += numbers.seconds
        trial = Trial(scaled, values, shape, self._spent, failure=numbers.failure)
        if not numbers.failure:
            self._fill(trial, numbers)
        return trial

    def _fill(self, trial: Trial, numbers: DesignNumbers) -> None:
        """Objective and limits of a simulated design, scaled."""
        problem, shape = self._problem, trial.shape
        if problem.objective.experiment is None:
            name = problem.objective.name
            trial.signed = problem.sign * np.array([shape.value(name)])
            trial.signed_slopes = problem.sign * (shape.gradient(name) * self._range)[None]
        else:
            objectives = [by[problem.objective] for by in numbers.by_condition]
            trial.signed = problem.sign * np.array([one.value for one in objectives])
            trial.signed_slopes = problem.sign * np.array(
                [one.slopes * self._range for one in objectives]
            )
        trial.objective = problem.sign * float(trial.signed.max())
        if problem.parts:
            worst = numbers.by_condition[int(trial.signed.argmax())]
            turns = np.array([worst[part].slopes * self._range for part in problem.parts])
            trial.of_parts = 2 * turns.T @ turns / max(len(problem.objective.values), 1)
        values, slopes = [], []
        for i, limit in enumerate(problem.limits):
            if limit.quantity.experiment is None:
                trial.limits.append(shape.value(limit.quantity.name))
                continue
            measured = [by[limit.quantity] for by in numbers.by_condition]
            if np.isnan(self._limit[i]):
                self._limit[i] = limit.sign * max(limit.sign * one.value for one in measured)
            size = size_of(self._limit[i])
            for one in measured:
                values.append(limit.sign * (one.value - self._limit[i]) / size)
                slopes.append(limit.sign * one.slopes * self._range / size)
            trial.limits.append(limit.sign * max(limit.sign * one.value for one in measured))
        trial.above = np.array(values)
        trial.above_slopes = np.array(slopes).reshape(len(values), len(trial.scaled))
        trial.excess = max(float(trial.above.max(initial=0.0)), 0.0)

    # -- steps -----------------------------------------------------------------------------------

    def _step(
        self, here: Trial, model: ObjectiveModel, simulated: Rows, radius: float
    ) -> tuple[Floats, float] | None:
        """The best step in the box, and the gain it promises; None if it breaks the shape.

        Where no simulated limit is there to be broken by a long step, the nearest step that keeps
        the limits of the shape will do, too.
        """
        box = (
            np.maximum(-radius, -here.scaled),
            np.minimum(radius, 1.0 - here.scaled),
        )
        held = ShapeLimits(self._limits(), self._range, self._policy)
        step: Floats = np.zeros(len(here.scaled))
        held.at(here.shape, step)
        n, last = len(step), step
        nearest = not len(simulated.values)
        most = self._policy.aimed if nearest else self._policy.corrections
        for number in range(most + nearest * self._policy.nearest):
            aimed = number < most
            aim = (
                model
                if aimed
                else ObjectiveModel(np.ones(1), -self._policy.shorter * step[None], np.eye(n))
            )
            step, _ = best_step(aim, simulated, held.rows, box, self._policy.penalty)
            step = self._rounded(here.scaled + step) - here.scaled
            try:
                shape = self._shapes.at(self._values(here.scaled + step))
                full = True
                while held.folds(shape):
                    # slopes lead nowhere there; they are taken on the way from the last shape
                    far = np.abs(step - last).max() > self._policy.least_radius
                    full, step = (
                        False,
                        self._rounded(here.scaled + (last + far * step) / (1 + far)),
                    )
                    step = step - here.scaled
                    shape = self._shapes.at(self._values(here.scaled + step))
                last = step
                worst = held.worst(shape)
            except ConfigError:
                return None
            if full and worst <= self._policy.kept:
                expected = model.at(np.zeros(n)) - model.at(step)
                enough = aimed or expected > self._policy.enough * abs(float(model.values.max()))
                return (step, expected) if enough else None
            held.at(shape, step)
        return None

    def _into_limits(self, scaled: Floats) -> Floats:
        """The nearest design that keeps the limits of the shape.

        Raises:
            NoStart: one line, where none was found.
        """
        here = self._rounded(scaled)
        step: Floats = np.zeros(len(scaled))
        held = ShapeLimits(self._limits(), self._range, self._policy)
        n = len(here)
        near = ObjectiveModel(np.ones(1), np.zeros((1, n)), np.eye(n))
        worst = np.inf
        for _ in range(3 * self._policy.corrections):
            shape = self._shapes.at(self._values(here + step))
            worst = held.worst(shape)
            if worst <= self._policy.kept:
                return self._rounded(here + step)
            held.at(shape, step)
            step, _ = best_step(near, held.rows, Rows.none(n), (-here, 1.0 - here), 1e3)
            step = self._rounded(here + step) - here
        limit, value = held.worst_limit(shape)
        raise NoStart(
            f"constraints: {limit}: {value:.4g} at the nearest design; allowed: limits that a "
            "design within the parameters' ranges can keep"
        )


def bundle(here: Trial, trials: Sequence[Trial], bend: Floats, last: int) -> Rows:
    """Return limits of simulated quantities, linear at a design and at the last ones around it.

    A largest stretch is where two places take turns the largest of several functions. What it was
    at other designs tells of those; none of them may exclude the design itself.
    """
    rows = Rows(here.above, here.above_slopes, bend)
    around = [trial for trial in trials if trial is not here and not trial.failure]
    for other in around[-last:]:
        values = other.above + other.above_slopes @ (here.scaled - other.scaled)
        rows = rows.with_rows(Rows(np.minimum(values, here.above), other.above_slopes, bend))
    return rows


def predicted_limits(rows: Rows, step: Floats, limits: int) -> Floats:
    """Predict each of the limits after a step by a bundle of rows, shape (limits,)."""
    if not limits:
        return np.empty(0)
    every = (rows.values + rows.slopes @ step).reshape(-1, limits)
    return np.asarray(every.max(axis=0))


def bfgs_update(curvature: Floats, step: Floats, turn: Floats, *, fresh: bool) -> Floats:
    """Update the curvature after a step over which the gradient turned, by damped BFGS."""
    along = float(step @ turn)
    if fresh and along > 0:
        curvature = np.asarray(np.eye(len(step)) * along / float(step @ step), dtype=float)
    bent = curvature @ step
    size = float(step @ bent)
    if along < 0.2 * size:
        share = 0.8 * size / (size - along)
        turn = share * turn + (1 - share) * bent
        along = float(step @ turn)
    updated = curvature - np.outer(bent, bent) / size + np.outer(turn, turn) / along
    return np.asarray((updated + updated.T) / 2)

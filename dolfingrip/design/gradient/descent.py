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
from dolfingrip.design.gradient.evaluation import Floats, Simulated, Simulations
from dolfingrip.design.gradient.policy import POLICY
from dolfingrip.design.gradient.problem import Held, Problem
from dolfingrip.design.gradient.quantity import OF_MANY
from dolfingrip.design.gradient.shape import Shape, Shapes
from dolfingrip.design.gradient.subproblem import Model, Rows, best_step


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
    """

    scaled: Floats
    values: Floats
    shape: Shape
    simulations: int
    objective: float = float("nan")
    excess: float = 0.0
    limits: list[float] = field(default_factory=list)
    accepted: bool = False
    radius: float = 0.0
    expected: float = 0.0
    failure: str = ""
    # signed objectives (k,), their slopes (k, n); limits c (m,) and slopes (m, n), scaled
    _f: Floats = field(default_factory=lambda: np.empty(0), repr=False)
    _g: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    _c: Floats = field(default_factory=lambda: np.empty(0), repr=False)
    _j: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)


@dataclass(slots=True)
class Descent:
    """What a descent found.

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
    limits: list[tuple[Held, float]]
    simulations: int
    seconds: float

    @property
    def start(self) -> Trial:
        """The design at which it began."""
        return self.trials[0]


class NoStart(ConfigError):
    """The start cannot be simulated, or no design keeps the limits."""


class Descender:
    """Looks for the best design of a problem.

    Args:
        problem: to be solved.
        simulations: of its designs.
        say: called with each design that was simulated.
    """

    def __init__(
        self,
        problem: Problem,
        simulations: Simulations,
        say: Callable[[Trial, Sequence[tuple[Held, float]]], None] = lambda trial, limits: None,
    ) -> None:
        self._problem, self._simulations, self._say = problem, simulations, say
        self._shapes = Shapes(problem)
        self._low = np.array([each.low for each in problem.variables])
        self._range = np.array([each.high for each in problem.variables]) - self._low
        self._spent, self._seconds = 0, 0.0
        self._limit: list[float] = []

    # -- the whole -------------------------------------------------------------------------------

    def run(self) -> Descent:
        """Descend.

        Raises:
            NoStart: one line.
        """
        problem = self._problem
        starts = np.array([each.start for each in problem.variables])
        scaled = (starts - self._low) / self._range
        given = self._shapes.at(self._values(scaled))
        self._limit = [
            given.value(each.quantity.name)
            if each.limit is None and each.quantity.experiment is None
            else (float("nan") if each.limit is None else each.limit)
            for each in problem.limits
        ]
        here = self._simulated(self._into_limits(scaled))
        if here.failure:
            raise NoStart(f"the start cannot be simulated: {here.failure}")
        here.accepted = True
        self._tell(here)
        trials, n = [here], len(starts)
        radius = problem.method.radius
        bend: Floats = np.zeros(len(here._c))
        curvature, fresh = np.eye(n) * POLICY.enough * abs(here._f).max(), True
        ending = "the largest number of simulations is reached"
        cost = self._spent
        while self._spent + cost <= problem.method.simulations:
            worst = int(here._f.argmax())
            model = Model(here._f, here._g, curvature)
            rows = _bundle(here, trials, bend)
            found = self._step(here, model, rows, radius)
            if found is None:
                radius *= POLICY.failed
                if radius < POLICY.least_radius:
                    ending = "no shorter step keeps the limits of the shape"
                    break
                continue
            step, expected = found
            kept = here.excess <= POLICY.broken
            if kept and expected < POLICY.enough * abs(float(here._f.max())):
                ending = "no step promises more"
                break
            trial = self._simulated(self._rounded(here.scaled + step))
            trial.radius, trial.expected = radius, expected
            trials.append(trial)
            if trial.failure:
                self._tell(trial)
                radius = POLICY.failed * float(np.abs(step).max())
            else:
                step = trial.scaled - here.scaled
                off = trial._c - _foretold(_bundle(here, trials[:-1], 0.0 * bend), step, len(bend))
                bend = np.where(off > 0, 2 * off / float(step @ step), 0.5 * bend)
                turn = trial._g[worst] - here._g[worst]
                curvature, fresh = _learnt(curvature, step, turn, fresh=fresh), False
                gain = float(here._f.max() - trial._f.max())
                if kept:
                    trial.accepted = trial.excess <= POLICY.broken and gain > 0
                else:
                    trial.accepted = trial.excess < here.excess
                self._tell(trial)
                radius = self._next_radius(trial, step, gain, expected, kept=kept)
                if trial.accepted:
                    here = trial
            if radius < POLICY.least_radius:
                ending = "no shorter step improves"
                break
        limits = list(zip(problem.limits, self._limit, strict=True))
        return Descent(trials, here, ending, limits, self._spent, self._seconds)

    def _next_radius(
        self, trial: Trial, step: Floats, gain: float, expected: float, *, kept: bool
    ) -> float:
        """The radius after a step that was simulated."""
        reach = float(np.abs(step).max())
        if not trial.accepted:
            return POLICY.rejected * reach
        ratio = gain / expected if kept and expected > 0 else POLICY.good
        if ratio < POLICY.poor:
            return 0.5 * reach
        if ratio >= POLICY.good and reach > 0.9 * trial.radius:
            return min(2 * trial.radius, POLICY.largest_radius)
        return trial.radius

    def _tell(self, trial: Trial) -> None:
        self._say(trial, list(zip(self._problem.limits, self._limit, strict=True)))

    # -- designs ---------------------------------------------------------------------------------

    def _rounded(self, scaled: Floats) -> Floats:
        return np.asarray(np.round(np.clip(scaled, 0.0, 1.0), POLICY.digits), dtype=float)

    def _values(self, scaled: Floats) -> Floats:
        values = np.round(self._low + scaled * self._range, POLICY.digits - 2)
        return np.asarray(values + 0.0)  # no minus zero

    def _simulated(self, scaled: Floats) -> Trial:
        values = self._values(scaled)
        shape = self._shapes.at(values)
        found = self._simulations.at(values)
        self._spent += found.simulations
        self._seconds += found.seconds
        trial = Trial(scaled, values, shape, self._spent, failure=found.failure)
        if not found.failure:
            self._fill(trial, found)
        return trial

    def _fill(self, trial: Trial, found: Simulated) -> None:
        """Objective and limits of a simulated design, scaled."""
        problem, shape = self._problem, trial.shape
        if problem.objective.experiment is None:
            name = problem.objective.name
            trial._f = problem.sign * np.array([shape.value(name)])
            trial._g = problem.sign * (shape.gradient(name) * self._range)[None]
        else:
            each = [by[problem.objective] for by in found.by_condition]
            trial._f = problem.sign * np.array([one.value for one in each])
            trial._g = problem.sign * np.array([one.slopes * self._range for one in each])
        trial.objective = problem.sign * float(trial._f.max())
        values, slopes = [], []
        for i, limit in enumerate(problem.limits):
            if limit.quantity.experiment is None:
                trial.limits.append(shape.value(limit.quantity.name))
                continue
            measured = [by[limit.quantity] for by in found.by_condition]
            if np.isnan(self._limit[i]):
                self._limit[i] = limit.sign * max(limit.sign * one.value for one in measured)
            size = _size(self._limit[i])
            for one in measured:
                values.append(limit.sign * (one.value - self._limit[i]) / size)
                slopes.append(limit.sign * one.slopes * self._range / size)
            trial.limits.append(limit.sign * max(limit.sign * one.value for one in measured))
        trial._c = np.array(values)
        trial._j = np.array(slopes).reshape(len(values), len(trial.scaled))
        trial.excess = max(float(trial._c.max(initial=0.0)), 0.0)

    # -- steps -----------------------------------------------------------------------------------

    def _step(
        self, here: Trial, model: Model, simulated: Rows, radius: float
    ) -> tuple[Floats, float] | None:
        """The best step in the box, and the gain it promises; None if it breaks the shape."""
        box = (
            np.maximum(-radius, -here.scaled),
            np.minimum(radius, 1.0 - here.scaled),
        )
        held = _Linearised(self, here.scaled)
        step: Floats = np.zeros(len(here.scaled))
        held.at(here.shape, step)
        for _ in range(POLICY.corrections):
            step, _ = best_step(model, simulated, held.rows, box, POLICY.penalty)
            step = self._rounded(here.scaled + step) - here.scaled
            try:
                shape = self._shapes.at(self._values(here.scaled + step))
                worst = held.worst(shape)
            except ConfigError:
                return None
            if worst <= POLICY.kept:
                return step, model.at(np.zeros(len(step))) - model.at(step)
            held.at(shape, step)
        return None

    def _into_limits(self, scaled: Floats) -> Floats:
        """The nearest design that keeps the limits of the shape.

        Raises:
            NoStart: one line, where none was found.
        """
        here = self._rounded(scaled)
        step: Floats = np.zeros(len(scaled))
        held = _Linearised(self, here)
        n = len(here)
        near = Model(np.ones(1), np.zeros((1, n)), np.eye(n))
        worst = np.inf
        for _ in range(3 * POLICY.corrections):
            shape = self._shapes.at(self._values(here + step))
            worst = held.worst(shape)
            if worst <= POLICY.kept:
                return self._rounded(here + step)
            held.at(shape, step)
            step, _ = best_step(near, held.rows, Rows.none(n), (-here, 1.0 - here), 1e3)
            step = self._rounded(here + step) - here
        limit, value = held.worst_limit(shape)
        raise NoStart(
            f"constraints: {limit}: {value:.4g} at the nearest design; allowed: limits that a "
            "design within the parameters' ranges can keep"
        )


class _Linearised:
    """Limits of the shape, linearised where a step ends."""

    def __init__(self, owner: Descender, scaled: Floats) -> None:
        self._limits = [
            (limit, value)
            for limit, value in zip(owner._problem.limits, owner._limit, strict=True)
            if limit.quantity.experiment is None
        ]
        self._range, self._n = owner._range, len(scaled)
        self._chosen: dict[int, set[int]] = {}
        self.rows = Rows.none(self._n)

    def at(self, shape: Shape, step: Floats) -> None:
        """Linearise them at a shape that a step leads to."""
        values, slopes = [], []
        for i, (limit, value) in enumerate(self._limits):
            name, size = limit.quantity.name, _size(value)
            if name in OF_MANY:
                every = shape.rows(name)
                above: Floats = np.asarray(limit.sign * (every - value) / size, dtype=float)
                chosen = self._choose(i, above, size)
                slope = shape.row_gradients(name, chosen).T
                above = above[chosen]
            else:
                above = np.array([limit.sign * (shape.value(name) - value) / size])
                slope = shape.gradient(name)[None]
            scaled = limit.sign * slope * self._range / size
            # a little inside, so that it holds when what is left out of the linear part is small
            values.append(above - scaled @ step + POLICY.kept / 2)
            slopes.append(scaled)
        if values:
            c = np.concatenate(values)
            self.rows = Rows(c, np.concatenate(slopes), np.zeros(len(c)))

    def _choose(self, i: int, above: Floats, size: float) -> np.ndarray:
        """Rows that a step may break: the nearest ones, and those that one has broken."""
        known = self._chosen.setdefault(i, set())
        near = np.flatnonzero(above > -POLICY.near_mm / size)
        known.update(map(int, near[np.argsort(-above[near], kind="stable")][: POLICY.most_rows]))
        return np.array(sorted(known), dtype=np.int64)

    def _worsts(self, shape: Shape) -> list[float]:
        found = []
        for limit, value in self._limits:
            if limit.quantity.name == "overhang_deg":
                above = shape.rows("overhang_deg") - value
                found.append(float(above.max(initial=-1.0)) / _size(value))
                continue
            found.append(limit.sign * (shape.value(limit.quantity.name) - value) / _size(value))
        return found

    def worst(self, shape: Shape) -> float:
        """By how much the worst limit is broken, as a part of its size; below 0 if all are kept."""
        return max(self._worsts(shape), default=-1.0)

    def worst_limit(self, shape: Shape) -> tuple[Held, float]:
        """The limit that is broken most, and its quantity's value."""
        limit, _ = self._limits[int(np.argmax(self._worsts(shape)))]
        return limit, shape.value(limit.quantity.name)


def _bundle(here: Trial, trials: Sequence[Trial], bend: Floats) -> Rows:
    """Limits of simulated quantities, linear at a design and at the last ones around it.

    A largest stretch is where two places take turns the largest of several functions. What it was
    at other designs tells of those; none of them may exclude the design itself.
    """
    rows = Rows(here._c, here._j, bend)
    around = [each for each in trials if each is not here and not each.failure]
    for other in around[-POLICY.bundle :]:
        values = other._c + other._j @ (here.scaled - other.scaled)
        rows = rows.with_rows(Rows(np.minimum(values, here._c), other._j, bend))
    return rows


def _foretold(rows: Rows, step: Floats, limits: int) -> Floats:
    """What a bundle of rows says of each of the limits after a step, shape (limits,)."""
    if not limits:
        return np.empty(0)
    every = (rows.values + rows.slopes @ step).reshape(-1, limits)
    return np.asarray(every.max(axis=0))


def _size(limit: float) -> float:
    return abs(limit) if abs(limit) > 1e-9 else 1.0


def _learnt(curvature: Floats, step: Floats, turn: Floats, *, fresh: bool) -> Floats:
    """The curvature after a step over which the gradient turned, by damped BFGS."""
    along = float(step @ turn)
    if fresh and along > 0:
        curvature = np.asarray(np.eye(len(step)) * along / float(step @ step), dtype=float)
    bent = curvature @ step
    size = float(step @ bent)
    if along < 0.2 * size:
        share = 0.8 * size / (size - along)
        turn = share * turn + (1 - share) * bent
        along = float(step @ turn)
    found = curvature - np.outer(bent, bent) / size + np.outer(turn, turn) / along
    return np.asarray((found + found.T) / 2)

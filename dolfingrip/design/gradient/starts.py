"""Several starts of one problem, and what differs between where they end.

A quantity without gradients has a search in place of descents. Gaussian processes say where the
next design is simulated. Each condition, such as a food, has a process of its own; the worst
condition counts. The next design is where the worst one is expected to improve most on the best
design so far (Jones, Schonlau & Welch, J. Global Optim. 13, 1998), by draws from all processes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.stats import qmc

from dolfingrip.config import ConfigError
from dolfingrip.design.gradient.descent import (
    Descent,
    NoStart,
    Say,
    Trial,
    TrustRegionSQP,
    say_nothing,
)
from dolfingrip.design.gradient.evaluation import DesignNumbers, DesignSimulations
from dolfingrip.design.gradient.problem import Constraint, Floats, Problem, Scaling
from dolfingrip.design.gradient.shape import UnloadedShapes
from dolfingrip.design.quantities.grasp import GRASP
from dolfingrip.design.surrogate.process import GradientProcess
from dolfingrip.experiments.rigs.food import grasped
from dolfingrip.experiments.rigs.gripper import stands_of
from dolfingrip.experiments.simulate import Compute


@dataclass(frozen=True, slots=True)
class SearchPolicy:
    """The numbers of a search.

    Attributes:
        first: number of designs, the start among them, that are spread evenly before processes say
            more.
        candidates: number of designs all over the ranges among which the next one is chosen.
        near, reach: number of those around the best one, and their standard deviation as a part of
            the ranges.
        draws: of each process.
        enough: expected gain, as a part of the best objective, below which a search ends.
        seed: of the candidates and draws.
    """

    first: int = 5
    candidates: int = 2048
    near: int = 1024
    reach: float = 0.1
    draws: int = 256
    enough: float = 2e-3
    seed: int = 1


class BayesianSearch:
    """Looks for the best design of a problem whose objective has no gradient.

    Args:
        problem: with limits of the unloaded shape alone.
        simulations: of its designs.
        say: called with each design that was simulated.
        policy: numbers of the search.
    """

    def __init__(
        self,
        problem: Problem,
        simulations: DesignSimulations,
        say: Say = say_nothing,
        policy: SearchPolicy = SearchPolicy(),
    ) -> None:
        self._problem, self._simulations, self._say = problem, simulations, say
        self._policy = policy
        self._shapes = UnloadedShapes(problem)
        self._foods = [grasped(condition.base.food) for condition in problem.conditions]
        self._scaling = Scaling(problem.variables)
        self._random = np.random.default_rng(policy.seed)
        self._limits: list[tuple[Constraint, float]] = []

    def run(self) -> Descent:
        """Simulate until no design promises more, or the simulations are spent.

        Raises:
            NoStart: one line, where the start cannot be simulated.
        """
        problem = self._problem
        begin = self._scaling.start
        given = self._shapes.at(self._values(begin))
        self._limits = [
            (limit, given.value(limit.quantity.name) if limit.limit is None else limit.limit)
            for limit in problem.limits
        ]
        cost = len(problem.conditions)
        sobol = qmc.Sobol(len(begin), rng=self._policy.seed).random(self._policy.candidates)
        everywhere = np.array([row for row in sobol if self._kept(row)]).reshape(-1, len(begin))
        first = [begin, *everywhere[: self._policy.first - 1]]
        trials: list[Trial] = []
        spent, seconds = 0, 0.0
        best: Trial | None = None
        ending = "the largest number of simulations is reached"
        while spent + cost <= problem.method.simulations:
            expected = 0.0
            if len(trials) < len(first):
                scaled = first[len(trials)]
            else:
                assert best is not None
                scaled, expected = self._next(trials, best, everywhere)
                if expected < self._policy.enough * abs(best.objective):
                    ending = "no design promises more"
                    break
            trial = Trial(scaled, self._values(scaled), self._shapes.at(self._values(scaled)), 0)
            trial.expected = expected
            trial.limits = [trial.shape.value(limit.quantity.name) for limit, _ in self._limits]
            numbers = self._simulated(trial, best)
            spent, seconds = spent + numbers.simulations, seconds + numbers.seconds
            trial.simulations = spent
            if not trials and numbers.failure:
                raise NoStart(f"the start cannot be simulated: {numbers.failure}")
            trials.append(trial)
            best = trial if trial.accepted else best
            self._say(trial, self._limits)
        assert best is not None
        if failed := [trial.failure for trial in trials if trial.failure]:
            ending += f"; not known of {len(failed)} of {len(trials)} designs ({failed[-1]})"
        return Descent(trials, best, ending, self._limits, spent, seconds)

    def _simulated(self, trial: Trial, best: Trial | None) -> DesignNumbers:
        """Simulate a design, the best one's worst condition first, while it may be better.

        What was not simulated is NaN.
        """
        number = len(self._problem.conditions)
        trial.signed = np.full(number, np.nan)
        order = range(number) if best is None else np.argsort(-best.signed, kind="stable")
        bar = np.inf if best is None else float(best.signed.max())
        total = DesignNumbers()
        for batch in [list(order)] if best is None else [[int(i)] for i in order]:
            numbers = self._simulations.at(trial.values, gradients=False, only=batch)
            total.simulations += numbers.simulations
            total.seconds += numbers.seconds
            total.failure = trial.failure = numbers.failure
            if numbers.failure:
                return total
            for i in batch:
                value = numbers.by_condition[i][self._problem.objective].value
                trial.signed[i] = self._problem.sign * value
            if np.nanmax(trial.signed) >= bar:
                break
        trial.objective = self._problem.sign * float(np.nanmax(trial.signed))
        trial.accepted = best is None or bool(np.nanmax(trial.signed) < bar)
        return total

    def _values(self, scaled: Floats) -> Floats:
        return self._scaling.values(scaled, 6)

    def _kept(self, scaled: Floats) -> bool:
        """Tell whether there is such a finger within the limits, and a gripper for each food."""
        values = self._values(scaled)
        try:
            shape = self._shapes.at(values)
            for condition, food in zip(self._problem.conditions, self._foods, strict=True):
                stands_of(condition.config(self._problem.variables, list(map(float, values))), food)
        except ConfigError:
            return False
        return all(
            limit.sign * (shape.value(limit.quantity.name) - value) <= 0
            for limit, value in self._limits
        )

    def _next(
        self, trials: Sequence[Trial], best: Trial, everywhere: Floats
    ) -> tuple[Floats, float]:
        """The design that is expected to gain most, and that gain."""
        near = best.scaled + self._policy.reach * self._random.standard_normal(
            (self._policy.near, len(best.scaled))
        )
        near = np.array([point for point in np.clip(near, 0.0, 1.0) if self._kept(point)])
        candidates = np.concatenate([everywhere, near.reshape(-1, len(best.scaled))])
        every = np.array([trial.scaled for trial in trials])
        signed = np.array([trial.signed for trial in trials])
        # what cannot be simulated is as bad as the worst that can
        failed = np.array([bool(trial.failure) for trial in trials])
        drawn = np.full((self._policy.draws, len(candidates)), -np.inf)
        for objectives in signed.T:
            values = np.where(failed & np.isnan(objectives), np.nanmax(objectives), objectives)
            inputs, values = every[~np.isnan(values)], values[~np.isnan(values)]
            if np.ptp(values) == 0:
                drawn = np.maximum(drawn, values[0])
                continue
            # margins lie decades apart
            process = GradientProcess(inputs, np.arcsinh(values))
            mean, deviation = process.predict(candidates)
            noise = self._random.standard_normal((self._policy.draws, 1))
            drawn = np.maximum(drawn, np.sinh(mean + noise * deviation))
        gains = np.maximum(float(best.signed.max()) - drawn, 0.0).mean(axis=0)
        if not gains.any():  # nothing is known to tell candidates apart
            return everywhere[len(trials) % len(everywhere)], 0.0
        chosen = int(gains.argmax())
        return candidates[chosen], float(gains[chosen])


SEED: Final = 33
"""Of the random starts, so that a run that goes on begins at the same places."""

AS_GOOD: Final = 0.01
"""Part of the best objective within which another start's counts as good as it."""

APART: Final = 0.02
"""Part of a variable's range beyond which two designs differ in it."""


@dataclass(slots=True)
class Starts:
    """Descents from several starts.

    Attributes:
        descents: one for each start, in order; the error where it has no design that can be
            simulated.
    """

    descents: list[Descent | NoStart]

    def best(self, problem: Problem) -> Descent:
        """The descent that ends best of those that keep the limits."""
        descents = [d for d in self.descents if isinstance(d, Descent)]
        return min(descents, key=lambda d: (d.best.excess, problem.sign * d.best.objective))

    def facts(self, problem: Problem) -> dict[str, Any]:
        """Objectives, and in which variables designs that are as good as the best one differ."""
        best = self.best(problem).best
        rows: list[dict[str, Any]] = []
        good: list[Trial] = []
        for one in self.descents:
            if isinstance(one, NoStart):
                rows.append({"ending": str(one)})
                continue
            apart = abs(one.best.objective - best.objective)
            as_good = apart <= AS_GOOD * abs(best.objective)
            good += [one.best] if as_good else []
            rows.append(
                {
                    "start": one.start.objective,
                    "objective": one.best.objective,
                    "simulations": one.simulations,
                    "ending": one.ending,
                    "as_good": as_good,
                }
            )
        scaled = np.array([trial.scaled for trial in good])
        values = np.array([trial.values for trial in good])
        return {
            "starts": rows,
            "differ": {
                variable.key: [float(values[:, i].min()), float(values[:, i].max())]
                for i, variable in enumerate(problem.variables)
                if np.ptp(scaled[:, i]) > APART
            },
        }


def begins(problem: Problem) -> list[np.ndarray | None]:
    """Scaled values of each start; None: the problem's own."""
    random = np.random.default_rng(SEED)
    further = random.uniform(0, 1, (problem.method.starts - 1, len(problem.variables)))
    return [None, *further]


def solve(
    problem: Problem,
    compute: Compute,
    say: Say = say_nothing,
    search: SearchPolicy = SearchPolicy(),
) -> Starts:
    """Find the best design from each start by a :class:`.TrustRegionSQP`, of a grasp by a search.

    Args:
        problem: the design problem.
        compute: computes jobs.
        say: called with each design that was simulated.
        search: numbers of a grasp's search.

    Returns:
        The descents.

    Raises:
        NoStart: one line, where the problem's own start has no design.
    """
    simulations = DesignSimulations(problem, compute)
    if problem.objective.experiment == GRASP:
        return Starts([BayesianSearch(problem, simulations, say, search).run()])
    solver = TrustRegionSQP(problem, simulations, say)
    descents: list[Descent | NoStart] = [solver.run()]
    for begin in begins(problem)[1:]:
        try:
            descents.append(solver.run(begin))
        except NoStart as error:
            descents.append(error)
    return Starts(descents)

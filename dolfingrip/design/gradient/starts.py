"""Several starts of one problem, and what differs between where they end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from dolfingrip.design.gradient.descent import NoStart, TrustRegionSQP
from dolfingrip.design.gradient.evaluation import DesignSimulations
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.search import BayesianSearch, SearchPolicy
from dolfingrip.design.gradient.trial import Descent, Say, Trial, say_nothing
from dolfingrip.design.quantities.grasp import GRASP
from dolfingrip.experiments.simulate import Compute

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
        descents: one for each start, in order; None where it has no design that can be simulated.
        failures: why not; "" of the others.
    """

    descents: list[Descent | None]
    failures: list[str]

    def best(self, problem: Problem) -> Descent:
        """The descent that ends best of those that keep the limits."""
        found = [each for each in self.descents if each is not None]
        return min(found, key=lambda each: (each.best.excess, problem.sign * each.best.objective))

    def facts(self, problem: Problem) -> dict[str, Any]:
        """Objectives, and in which variables designs that are as good as the best one differ."""
        best = self.best(problem).best
        rows: list[dict[str, Any]] = []
        for one, failure in zip(self.descents, self.failures, strict=True):
            if one is None:
                rows.append({"ending": failure})
                continue
            rows.append(
                {
                    "start": one.start.objective,
                    "objective": one.best.objective,
                    "simulations": one.simulations,
                    "ending": one.ending,
                    "as_good": self._as_good(one.best, best),
                }
            )
        good = [each.best for each in self.descents if each and self._as_good(each.best, best)]
        scaled = np.array([each.scaled for each in good])
        values = np.array([each.values for each in good])
        return {
            "starts": rows,
            "differ": {
                variable.key: [float(values[:, i].min()), float(values[:, i].max())]
                for i, variable in enumerate(problem.variables)
                if np.ptp(scaled[:, i]) > APART
            },
        }

    @staticmethod
    def _as_good(one: Trial, best: Trial) -> bool:
        return abs(one.objective - best.objective) <= AS_GOOD * abs(best.objective)


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
        return Starts([BayesianSearch(problem, simulations, say, search).run()], [""])
    solver = TrustRegionSQP(problem, simulations, say)
    every = Starts([solver.run()], [""])
    for begin in begins(problem)[1:]:
        try:
            every.descents.append(solver.run(begin))
            every.failures.append("")
        except NoStart as error:
            every.descents.append(None)
            every.failures.append(str(error))
    return every

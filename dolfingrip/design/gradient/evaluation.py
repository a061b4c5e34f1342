"""A design's numbers: those of its shape at once, those of experiments by jobs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dolfingrip.config import Config
from dolfingrip.design.campaign import grasps
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.quantity import GRASP, Quantity
from dolfingrip.design.gradient.simulate import grasp_job, job
from dolfingrip.jobs.job import Answer, Data, Job

Floats = NDArray[np.float64]

Compute = Callable[[Sequence[Job]], list[Answer]]
"""Answers of jobs, in their order."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A quantity of a design with its derivatives by the variables.

    Attributes:
        value: in the quantity's unit.
        slopes: shape (variables,).
    """

    value: float
    slopes: Floats


@dataclass(slots=True)
class Simulated:
    """What the simulations of a design found.

    Attributes:
        by_condition: for each condition the quantities of experiments.
        simulations: load paths that were followed.
        seconds: they took in all.
        failure: class and sentence of the first one that failed; "" if none did.
    """

    by_condition: list[dict[Quantity, Measured]] = field(default_factory=list)
    simulations: int = 0
    seconds: float = 0.0
    failure: str = ""


class Simulations:
    """Simulates the designs of a problem.

    Args:
        problem: with objective, limits and conditions.
        compute: what computes jobs.
    """

    def __init__(self, problem: Problem, compute: Compute) -> None:
        self._problem, self._compute = problem, compute
        wanted = [problem.objective, *(limit.quantity for limit in problem.limits)]
        self.quantities = list(dict.fromkeys(each for each in wanted if each.experiment))
        starts = [each.start for each in problem.variables]
        self._starts = [each.config(problem.variables, starts) for each in problem.conditions]

    @property
    def experiments(self) -> list[str]:
        """Experiments of a design, in the order of the quantities."""
        return list(dict.fromkeys(str(each.experiment) for each in self.quantities))

    def at(
        self,
        values: Sequence[float] | Floats,
        *,
        gradients: bool = True,
        only: Sequence[int] | None = None,
        finer: Callable[[Config], Config] | None = None,
    ) -> Simulated:
        """Simulate a design under all conditions.

        Args:
            values: of the variables.
            gradients: whether derivatives are wanted.
            only: numbers of the conditions; default: all.
            finer: makes a configuration's mesh another, which is then that of the design itself.

        Raises:
            ConfigError: one line, where there is no such finger.
        """
        keys = [each.key for each in self._problem.variables] if gradients else []
        jobs: list[Job] = []
        owners: list[tuple[int, list[Quantity], list[tuple[str, float]]]] = []
        for number in range(len(self._problem.conditions)) if only is None else only:
            condition = self._problem.conditions[number]
            config = condition.config(self._problem.variables, list(map(float, values)))
            made_for: Config | None = self._starts[number]
            if finer is not None:
                config, made_for = finer(config), finer(self._starts[number])
            for experiment in self.experiments:
                asked = [each for each in self.quantities if each.experiment == experiment]
                if experiment == GRASP:
                    jobs.append(grasp_job(config))
                    owners.append((number, asked, []))
                    continue
                places = list(dict.fromkeys((q.where, value) for q in asked for value in q.values))
                columns = list(dict.fromkeys(each.name for each in asked))
                highest = max((v for column, v in places if column == "pressure_kPa"), default=0.0)
                if highest > config.experiment.max_pressure_kPa:
                    config = config.changed(experiment={"max_pressure_kPa": highest})
                jobs.append(job(config, made_for, experiment, places, columns, keys))
                owners.append((number, asked, places))
        answers = self._compute(jobs)
        found = Simulated(
            [{} for _ in self._problem.conditions],
            len(jobs),
            sum(each.wall_s or 0.0 for each in answers),
        )
        for (number, asked, places), answer in zip(owners, answers, strict=True):
            if answer.result is None:
                found.failure = found.failure or f"{answer.failure_class}: {answer.failure}"
                continue
            for one in asked:
                if one.experiment == GRASP:
                    measured = _grasped(answer.result)
                else:
                    measured = self._mean(one, places, answer.result, gradients)
                found.by_condition[number][one] = measured
        return found

    def _mean(
        self, one: Quantity, places: list[tuple[str, float]], result: Data, gradients: bool
    ) -> Measured:
        at = [places.index((one.where, value)) for value in one.values]
        value = float(np.mean([result["values"][i][one.name] for i in at]))
        keys = [each.key for each in self._problem.variables]
        slopes = np.zeros(len(keys))
        if gradients:
            every = [[result["gradients"][i][one.name][key] for key in keys] for i in at]
            slopes = np.mean(every, axis=0)
        return Measured(value, np.asarray(slopes, dtype=float))


def _grasped(result: Data) -> Measured:
    """The margin of a grasp, which has no slopes."""
    return Measured(float(result["outputs"][grasps.PICKUP]), np.empty(0))

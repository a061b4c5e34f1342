"""A design's numbers: those of its shape at once, those of experiments by jobs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dolfingrip.channels import PRESSURE
from dolfingrip.config import Config
from dolfingrip.design.campaign import grasps
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.quantity import GRASP, Quantity
from dolfingrip.experiments.request import Answer, Place, Request

Floats = NDArray[np.float64]

Compute = Callable[[Sequence[Request]], list[Answer]]
"""From requests to their answers, in order."""


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
        compute: what computes requests.
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
        keys = [each.key for each in self._problem.variables] if gradients else None
        requests: list[Request] = []
        owners: list[tuple[int, list[Quantity]]] = []
        for number in range(len(self._problem.conditions)) if only is None else only:
            condition = self._problem.conditions[number]
            config = condition.config(self._problem.variables, list(map(float, values)))
            made_for = self._starts[number]
            if finer is not None:
                config, made_for = finer(config), finer(made_for)
            for experiment in self.experiments:
                asked = [each for each in self.quantities if each.experiment == experiment]
                if experiment == GRASP:
                    requests.append(Request.of(experiment, config))
                else:
                    requests.append(_at_places(experiment, config, made_for, asked, keys))
                owners.append((number, asked))
        answers = self._compute(requests)
        found = Simulated(
            [{} for _ in self._problem.conditions],
            len(requests),
            sum(each.wall_s or 0.0 for each in answers),
        )
        for (number, asked), request, answer in zip(owners, requests, answers, strict=True):
            if answer.failure_class is not None:
                found.failure = found.failure or f"{answer.failure_class}: {answer.failure}"
                continue
            for one in asked:
                if one.experiment == GRASP:
                    margin = grasps.outputs_of(answer)[grasps.PICKUP]
                    measured = Measured(margin, np.empty(0))  # which has no slopes
                else:
                    measured = self._mean(one, request.places, answer, gradients)
                found.by_condition[number][one] = measured
        return found

    def _mean(
        self, one: Quantity, places: Sequence[Place], answer: Answer, gradients: bool
    ) -> Measured:
        at = [places.index(Place(one.where, value)) for value in one.values]
        value = float(np.mean(answer.columns[one.name][at]))
        slopes = np.zeros(len(self._problem.variables))
        if gradients:
            keys = [each.key for each in self._problem.variables]
            slopes = np.array([np.mean(answer.slopes[one.name, key][at]) for key in keys])
        return Measured(value, slopes)


def _at_places(
    experiment: str,
    config: Config,
    made_for: Config,
    asked: Sequence[Quantity],
    keys: Sequence[str] | None,
) -> Request:
    """Ask for the quantities of an experiment at their places."""
    places = tuple(dict.fromkeys(Place(q.where, value) for q in asked for value in q.values))
    columns = tuple(dict.fromkeys(each.name for each in asked))
    highest = max((v for column, v in places if column == PRESSURE.name), default=0.0)
    if highest > config.experiment.max_pressure_kPa:
        config = config.changed(experiment={"max_pressure_kPa": highest})
    return Request.of(experiment, config, keys, columns=columns, places=places, made_for=made_for)

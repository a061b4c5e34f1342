"""A design's numbers: those of its shape at once, those of experiments by jobs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.config import Config
from dolfingrip.design.gradient.problem import Floats, Problem
from dolfingrip.design.quantities.grasp import GRASP, outputs_of
from dolfingrip.design.quantities.quantity import Quantity
from dolfingrip.design.quantities.readings import at_places, by_experiment, read
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import Compute


@dataclass(frozen=True, slots=True)
class NumberWithSlopes:
    """A quantity of a design with its derivatives by the variables.

    Attributes:
        value: in the quantity's unit.
        slopes: shape (variables,); (0,) without derivatives.
    """

    value: float
    slopes: Floats


@dataclass(slots=True)
class DesignNumbers:
    """The numbers of a design by its simulations.

    Attributes:
        by_condition: for each condition the quantities of experiments.
        simulations: load paths that were followed.
        seconds: they took in all.
        failure: class and sentence of the first one that failed; "" if none did.
    """

    by_condition: list[dict[Quantity, NumberWithSlopes]] = field(default_factory=list)
    simulations: int = 0
    seconds: float = 0.0
    failure: str = ""


class DesignSimulations:
    """Simulates the designs of a problem.

    Args:
        problem: with objective, limits and conditions.
        compute: what computes requests.
    """

    def __init__(self, problem: Problem, compute: Compute) -> None:
        self._problem, self._compute = problem, compute
        wanted = [problem.objective, *(limit.quantity for limit in problem.limits)]
        if problem.against is not None:
            wanted.append(problem.against)
        wanted += problem.parts
        self.quantities = list(dict.fromkeys(q for q in wanted if q.experiment))
        starts = [v.start for v in problem.variables]
        self._starts = [case.config(problem.variables, starts) for case in problem.conditions]

    def at(
        self,
        values: Sequence[float] | Floats,
        *,
        gradients: bool = True,
        only: Sequence[int] | None = None,
        finer: Callable[[Config], Config] | None = None,
    ) -> DesignNumbers:
        """Simulate a design under all conditions.

        Args:
            values: of the variables.
            gradients: whether derivatives are wanted.
            only: numbers of the conditions; default: all.
            finer: makes a configuration's mesh another, which is then that of the design itself.

        Raises:
            ConfigError: one line, where there is no such finger.
        """
        keys = [v.key for v in self._problem.variables] if gradients else None
        requests: list[Request] = []
        owners: list[tuple[int, list[Quantity]]] = []
        for number in range(len(self._problem.conditions)) if only is None else only:
            condition = self._problem.conditions[number]
            config = condition.config(self._problem.variables, list(map(float, values)))
            made_for = self._starts[number]
            if finer is not None:
                config, made_for = finer(config), finer(made_for)
            for experiment, wanted in by_experiment(self.quantities).items():
                if experiment == GRASP:
                    requests.append(Request.of(experiment, config))
                else:
                    requests.append(at_places(experiment, wanted, config, keys, made_for=made_for))
                owners.append((number, wanted))
        answers = self._compute(requests)
        numbers = DesignNumbers(
            [{} for _ in self._problem.conditions],
            len(requests),
            sum(reply.wall_s or 0.0 for reply in answers),
        )
        for (number, wanted), request, answer in zip(owners, requests, answers, strict=True):
            if answer.failure_class is not None:
                numbers.failure = numbers.failure or f"{answer.failure_class}: {answer.failure}"
                continue
            for one in wanted:
                if one.experiment == GRASP:  # which has no slopes
                    value, slopes = outputs_of(answer)[one.name], dict[str, float]()
                else:
                    value, slopes = read(one, request, answer)
                by_variable = np.array([slopes.get(key, np.nan) for key in keys or ()])
                numbers.by_condition[number][one] = NumberWithSlopes(value, by_variable)
        return numbers

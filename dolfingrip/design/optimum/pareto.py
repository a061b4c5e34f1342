"""The Pareto front of two outputs of a surrogate, and the choice along it (section IV.B)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pymoo.core.problem import Problem
from pymoo.termination import get_termination
from scipy import optimize

from dolfingrip.design.optimum.genetic import NSGA2Settings, nsga2
from dolfingrip.design.surrogate.surrogate import Surrogate
from dolfingrip.files.objective import NamedObjective

Matrix = npt.NDArray[np.float64]
Vector = npt.NDArray[np.float64]
Predict = Callable[[Matrix], Matrix]
"""From designs, shape (n, inputs), to both objectives, shape (n, 2)."""

SLACK = 1e-6
"""Amount by which a polished design may exceed its limit, in the unit of the objective."""


@dataclass(frozen=True)
class TradeOff:
    """Two objectives of a design that are traded off; the first is limited, the second improved.

    Attributes:
        predict: from designs to objectives.
        low, high: shape (inputs,), bounds of the designs.
        signs: 1 for an objective of which less is better, −1 where more is.
    """

    predict: Predict
    low: Vector
    high: Vector
    signs: tuple[float, float]

    @classmethod
    def of(cls, surrogate: Surrogate, objectives: Sequence[NamedObjective]) -> TradeOff:
        """Trade two outputs of a surrogate off, within the range that it learnt from.

        Args:
            surrogate: with both outputs.
            objectives: the limited one, the improved one.

        Returns:
            The trade-off.

        Raises:
            ConfigError: one line, where the surrogate lacks one of them.
        """
        columns = [surrogate.output(each.title) for each in objectives]
        first, second = (each.sign for each in objectives)
        # no warning: an optimiser stays within the bounds it is given, which are checked once
        return cls(
            lambda designs: surrogate.predict(designs, warn=False)[:, columns],
            surrogate.inputs.low,
            surrogate.inputs.high,
            (first, second),
        )

    def front(self, designs: Matrix, values: Matrix) -> ParetoFront:
        """Sort points that do not dominate one another by the first objective.

        Args:
            designs: shape (n, inputs).
            values: shape (n, 2), of the objectives.

        Returns:
            The front.
        """
        order = np.lexsort((values[:, 1], values[:, 0]))
        return ParetoFront(designs[order], values[order], self.signs)


@dataclass(frozen=True)
class ParetoFront:
    """Designs none of which is better than another in both objectives, by the rising first one.

    Attributes:
        designs: shape (points, inputs).
        values: shape (points, 2), of the objectives.
        signs: of the :class:`TradeOff`.
    """

    designs: Matrix
    values: Matrix
    signs: tuple[float, float]

    def __len__(self) -> int:
        return len(self.designs)

    def choose(self, limit: float) -> int | None:
        """Return the best point by the second objective that keeps a limit of the first one.

        On a front that is the last point within the limit.

        Args:
            limit: in the unit of the first objective.

        Returns:
            Row of the point; None if no point keeps the limit.
        """
        first, second = (self.values * self.signs).T
        within = np.flatnonzero(first <= self.signs[0] * limit)
        return int(within[second[within].argmin()]) if within.size else None


def spread(values: Matrix, count: int) -> npt.NDArray[np.int_]:
    """Return points evenly far apart along a front, both ends among them.

    Distance is measured with each objective divided by its range over the front.

    Args:
        values: shape (points, 2), of the objectives, in the order along the front.
        count: largest number of points.

    Returns:
        Their rows.
    """
    width = np.ptp(values, axis=0)
    steps = np.diff(values / np.where(width > 0, width, 1.0), axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    wanted = np.linspace(0.0, along[-1], count)
    return np.unique(np.abs(along[:, None] - wanted).argmin(axis=0))


class _Designs(Problem):
    """A trade-off as pymoo minimises it, a whole population at a time."""

    def __init__(self, asked: TradeOff) -> None:
        super().__init__(n_var=len(asked.low), n_obj=2, xl=asked.low, xu=asked.high)
        self.asked = asked

    def _evaluate(self, x: Matrix, out: dict[str, Matrix], *_: object, **__: object) -> None:
        out["F"] = self.asked.predict(x) * self.asked.signs


def fronts(
    asked: TradeOff,
    settings: NSGA2Settings,
    at: Iterable[int] = (),
    progress: Callable[[int], None] | None = None,
) -> dict[int, ParetoFront]:
    """Run NSGA-II once and keep its front after some generations.

    What NSGA-II has after generation g does not depend on how many are to follow: its random
    numbers are drawn in order, and nothing in it knows the end. So one run of 200 generations
    holds, number for number, the shorter runs of the same seed and rates (tested).

    Args:
        asked: objectives and bounds.
        settings: the last of ``at`` may not exceed its generations.
        at: generations, the random first one counted as 1; only the last where empty.
        progress: called with the number of generations done.

    Returns:
        Fronts by generation.
    """
    wanted = set(at) or {settings.generations}
    algorithm = nsga2(settings)
    algorithm.setup(
        _Designs(asked),
        # one more than needed: the run is stepped here, and pymoo's own end does nothing for it
        termination=get_termination("n_gen", settings.generations + 1),
    )
    found = {}
    for generation in range(1, settings.generations + 1):
        algorithm.next()
        if generation in wanted:
            designs, values = algorithm.opt.get("X", "F")
            found[generation] = asked.front(designs, values * asked.signs)
        if progress is not None:
            progress(generation)
    return found


def polish(asked: TradeOff, start: Vector, limit: float) -> tuple[Vector, Vector] | None:
    """Find the best design at a limit by a gradient method from a point of the front.

    NSGA-II chooses among the points it has, so its choice stops a little short of the limit; this
    shows by how much. It is reported in addition to that choice and does not replace it.

    Args:
        asked: objectives and bounds.
        start: shape (inputs,).
        limit: of the first objective, in its unit.

    Returns:
        The design, and its objectives, shape (2,); None where SLSQP finds nothing better.
    """

    def signed(x: Vector, column: int) -> float:
        return asked.signs[column] * float(asked.predict(x[None, :])[0, column])

    most = asked.signs[0] * limit
    result = optimize.minimize(
        lambda x: signed(x, 1),
        start,
        method="SLSQP",
        bounds=list(zip(asked.low, asked.high, strict=True)),
        constraints={"type": "ineq", "fun": lambda x: most - signed(x, 0)},
        options={"ftol": 1e-10},
    )
    x = np.clip(result.x, asked.low, asked.high)
    if not result.success or signed(x, 0) > most + SLACK or signed(x, 1) > signed(start, 1):
        return None
    return x, asked.predict(x[None, :])[0]

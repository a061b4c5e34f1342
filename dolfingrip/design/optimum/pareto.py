"""The Pareto front of two outputs of a surrogate, and the choice along it (section IV.B)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pymoo.core.problem import Problem
from pymoo.termination import get_termination
from scipy import optimize

from dolfingrip.channels import FORCE
from dolfingrip.design.optimum.genetic import Settings, nsga2
from dolfingrip.design.surrogate.surrogate import Surrogate

Matrix = npt.NDArray[np.float64]
Vector = npt.NDArray[np.float64]
Predict = Callable[[Matrix], Matrix]
"""Designs, shape (n, inputs), to objectives, shape (n, 2): offset to keep low, force to raise."""

COG = "cog_offset_mm"
"""COG offset of the undeformed finger, which is kept low as the blocked force is raised."""


@dataclass(frozen=True)
class Front:
    """Designs none of which is better than another in both objectives, by rising COG offset.

    Attributes:
        designs: shape (points, inputs).
        cog_mm: shape (points,), the objective that is kept low.
        force_N: shape (points,), the objective that is raised.
    """

    designs: Matrix
    cog_mm: Vector
    force_N: Vector

    def __len__(self) -> int:
        return len(self.designs)

    def choose(self, cog_max_mm: float) -> int | None:
        """The point of greatest force with a COG offset up to the limit; None where none has.

        On a front that is the last point within the limit.
        """
        within = np.flatnonzero(self.cog_mm <= cog_max_mm)
        return int(within[self.force_N[within].argmax()]) if within.size else None

    def spread(self, count: int) -> npt.NDArray[np.int_]:
        """Points evenly far apart along the front, both ends among them; at most ``count``.

        Distance is measured with each objective divided by its range over the front.
        """
        both = np.column_stack([self.cog_mm, self.force_N])
        width = np.ptp(both, axis=0)
        steps = np.diff(both / np.where(width > 0, width, 1.0), axis=0)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
        wanted = np.linspace(0.0, along[-1], count)
        return np.unique(np.abs(along[:, None] - wanted).argmin(axis=0))


class _Designs(Problem):
    """Two objectives of a surrogate as pymoo minimises them, a whole population at a time."""

    def __init__(self, predict: Predict, low: Vector, high: Vector) -> None:
        super().__init__(n_var=len(low), n_obj=2, xl=low, xu=high)
        self.predict = predict

    def _evaluate(self, x: Matrix, out: dict[str, Matrix], *_: object, **__: object) -> None:
        out["F"] = self.predict(x) * (1.0, -1.0)


def objectives(surrogate: Surrogate, cog: str = COG, force: str = FORCE.name) -> Predict:
    """The two outputs that are traded off against each other, the first kept low.

    Raises:
        ConfigError: one line, where the surrogate lacks one of them.
    """
    columns = [surrogate.output(cog), surrogate.output(force)]
    # no warning: an optimiser stays within the bounds it is given, which are checked once
    return lambda designs: surrogate.predict(designs, warn=False)[:, columns]


def fronts(
    predict: Predict,
    low: Vector,
    high: Vector,
    settings: Settings,
    at: Iterable[int] = (),
    progress: Callable[[int], None] | None = None,
) -> dict[int, Front]:
    """Run NSGA-II once and keep its front after some generations.

    What NSGA-II has after generation g does not depend on how many are to follow: its random
    numbers are drawn in order, and nothing in it knows the end. So one run of 200 generations
    holds, number for number, the shorter runs of the same seed and rates (tested).

    Args:
        predict: from designs to the two objectives.
        low, high: bounds of the designs, shape (inputs,).
        settings: the last of ``at`` may not exceed its generations.
        at: generations, the random first one counted as 1; only the last where empty.
        progress: called with the number of generations done.

    Returns:
        Fronts by generation.
    """
    wanted = set(at) or {settings.generations}
    algorithm = nsga2(settings)
    algorithm.setup(
        _Designs(predict, low, high),
        # one more than needed: the run is stepped here, and pymoo's own end does nothing for it
        termination=get_termination("n_gen", settings.generations + 1),
    )
    found = {}
    for generation in range(1, settings.generations + 1):
        algorithm.next()
        if generation in wanted:
            designs, values = algorithm.opt.get("X", "F")
            found[generation] = front(designs, values * (1.0, -1.0))
        if progress is not None:
            progress(generation)
    return found


def front(designs: Matrix, objectives: Matrix) -> Front:
    """Sort points that do not dominate one another, shapes (n, inputs) and (n, 2)."""
    order = np.lexsort((objectives[:, 1], objectives[:, 0]))
    return Front(designs[order], objectives[order, 0], objectives[order, 1])


def polish(
    predict: Predict, low: Vector, high: Vector, start: Vector, cog_max_mm: float
) -> tuple[Vector, float, float] | None:
    """The design of greatest force at a COG limit, by a gradient method from a point of the front.

    NSGA-II chooses among the points it has, so its choice stops a little short of the limit; this
    shows by how much. It is reported in addition to that choice and does not replace it.

    Args:
        start: shape (inputs,).

    Returns:
        The design, its COG offset (mm) and force (N); None where SLSQP finds nothing better.
    """

    def objective(column: int) -> Callable[[Vector], float]:
        return lambda x: float(predict(x[None, :])[0, column])

    cog, force = objective(0), objective(1)
    result = optimize.minimize(
        lambda x: -force(x),
        start,
        method="SLSQP",
        bounds=list(zip(low, high, strict=True)),
        constraints={"type": "ineq", "fun": lambda x: cog_max_mm - cog(x)},
        options={"ftol": 1e-10},
    )
    x = np.clip(result.x, low, high)
    if not result.success or cog(x) > cog_max_mm + 1e-6 or force(x) < force(start):
        return None
    return x, cog(x), force(x)

"""The Pareto front of two outputs of a surrogate, and the choice along it (section IV.B).

It is found by pymoo's NSGA-II, whose sorting is moocore's. Its Python loops over individuals are
replaced by array operations: of the time of a generation of 1000, most went into comparing pairs
one by one and into a distance matrix that looks for duplicates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.duplicate import DuplicateElimination
from pymoo.core.problem import Problem
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.selection.tournament import TournamentSelection
from pymoo.termination import get_termination
from scipy import optimize

from dolfingrip.design.surrogate.surrogate import Surrogate
from dolfingrip.files.objective import NamedObjective


@dataclass(frozen=True)
class NSGA2Settings:
    """NSGA-II's numbers: population and generations are the paper's.

    The paper does not name the rates it found best, nor any distribution index; the rates are
    pymoo's defaults, both in Table 1, and so are the indices.

    Attributes:
        population: designs in a generation.
        generations: the random first one counts.
        crossover: rate, of a mating.
        mutation: rate, of an input.
        seed: of the random numbers.
        eta_crossover, eta_mutation: distribution indices.
    """

    population: int = 1000
    generations: int = 200
    crossover: float = 0.9
    mutation: float = 0.5
    seed: int = 1
    eta_crossover: float = 15.0
    eta_mutation: float = 20.0


class NoCopies(DuplicateElimination):
    """Drops designs equal to another in every bit (pymoo's own asks for a distance of 1e-16)."""

    def _do(self, pop: Any, other: Any, is_duplicate: npt.NDArray[np.bool_]) -> Any:
        mine = self.func(pop)
        rows = mine if other is None else np.concatenate([self.func(other), mine])
        # a row as one opaque number: equal numbers are equal rows; adding 0 turns -0 into 0
        keys = np.ascontiguousarray(rows + 0.0).view(f"V{rows.shape[1] * 8}").ravel()
        _, first = np.unique(keys, return_index=True)
        seen = np.ones(len(rows), dtype=bool)
        seen[first] = False
        is_duplicate[seen[len(rows) - len(mine) :]] = True
        return is_duplicate


def tournament(pop: Any, pairs: npt.NDArray[np.int_], algorithm: Any, **_: Any) -> Any:
    """The winner of each pair: by dominance, else by crowding, else by chance.

    pymoo's ``binary_tournament`` for problems without constraints, all pairs at once.

    Args:
        pop: the population.
        pairs: shape (tournaments, 2), places in ``pop``.

    Returns:
        Shape (tournaments, 1), places in ``pop``.
    """
    values, crowding = pop.get("F", "crowding")
    first, second = pairs.T
    a, b = values[first], values[second]
    ahead = (a <= b).all(axis=1) & (a < b).any(axis=1)
    behind = (b <= a).all(axis=1) & (b < a).any(axis=1)
    undecided = ~ahead & ~behind
    lonelier = crowding[first] > crowding[second]
    tied = undecided & (crowding[first] == crowding[second])
    coin = algorithm.random_state.random(len(pairs)) < 0.5
    wins = ahead | (undecided & lonelier) | (tied & coin)
    return np.where(wins, first, second)[:, None]


def nsga2(settings: NSGA2Settings) -> NSGA2:
    """NSGA-II with the paper's crossover and mutation rates.

    pymoo has two probabilities for each operator: ``prob`` that a mating (or individual) is
    touched at all, ``prob_var`` that one of its variables is. As in the pymoo of the paper's time:

    - the crossover rate is SBX's ``prob``, a variable then being crossed with probability 0.5;
    - the mutation rate is that of each variable, PM's ``prob_var``, no individual being exempt
      (``prob = 1``); the usual 1/variables is 0.5 here.
    """
    return NSGA2(
        pop_size=settings.population,
        crossover=SBX(prob=settings.crossover, prob_var=0.5, eta=settings.eta_crossover),
        mutation=PM(prob=1.0, prob_var=settings.mutation, eta=settings.eta_mutation),
        selection=TournamentSelection(func_comp=tournament),
        eliminate_duplicates=NoCopies(),
        seed=settings.seed,
    )


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
        columns = [surrogate.output(objective.title) for objective in objectives]
        first, second = (objective.sign for objective in objectives)
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

    def __init__(self, trade_off: TradeOff) -> None:
        super().__init__(n_var=len(trade_off.low), n_obj=2, xl=trade_off.low, xu=trade_off.high)
        self.asked = trade_off

    def _evaluate(self, x: Matrix, out: dict[str, Matrix], *_: object, **__: object) -> None:
        out["F"] = self.asked.predict(x) * self.asked.signs


def fronts(
    trade_off: TradeOff,
    settings: NSGA2Settings,
    at: Iterable[int] = (),
    progress: Callable[[int], None] | None = None,
) -> dict[int, ParetoFront]:
    """Run NSGA-II once and keep its front after some generations.

    What NSGA-II has after generation g does not depend on how many are to follow: its random
    numbers are drawn in order, and nothing in it knows the end. So one run of 200 generations
    holds, number for number, the shorter runs of the same seed and rates (tested).

    Args:
        trade_off: objectives and bounds.
        settings: the last of ``at`` may not exceed its generations.
        at: generations, the random first one counted as 1; only the last where empty.
        progress: called with the number of generations done.

    Returns:
        Fronts by generation.
    """
    wanted = set(at) or {settings.generations}
    algorithm = nsga2(settings)
    algorithm.setup(
        _Designs(trade_off),
        # one more than needed: the run is stepped here, and pymoo's own end does nothing for it
        termination=get_termination("n_gen", settings.generations + 1),
    )
    by_generation = {}
    for generation in range(1, settings.generations + 1):
        algorithm.next()
        if generation in wanted:
            designs, values = algorithm.opt.get("X", "F")
            by_generation[generation] = trade_off.front(designs, values * trade_off.signs)
        if progress is not None:
            progress(generation)
    return by_generation


def polish(trade_off: TradeOff, start: Vector, limit: float) -> tuple[Vector, Vector] | None:
    """Find the best design at a limit by a gradient method from a point of the front.

    NSGA-II chooses among the points it has, so its choice stops a little short of the limit; this
    shows by how much. It is reported in addition to that choice and does not replace it.

    Args:
        trade_off: objectives and bounds.
        start: shape (inputs,).
        limit: of the first objective, in its unit.

    Returns:
        The design, and its objectives, shape (2,); None where SLSQP finds nothing better.
    """

    def signed(x: Vector, column: int) -> float:
        return trade_off.signs[column] * float(trade_off.predict(x[None, :])[0, column])

    most = trade_off.signs[0] * limit
    result = optimize.minimize(
        lambda x: signed(x, 1),
        start,
        method="SLSQP",
        bounds=list(zip(trade_off.low, trade_off.high, strict=True)),
        constraints={"type": "ineq", "fun": lambda x: most - signed(x, 0)},
        options={"ftol": 1e-10},
    )
    x = np.clip(result.x, trade_off.low, trade_off.high)
    if not result.success or signed(x, 0) > most + SLACK or signed(x, 1) > signed(start, 1):
        return None
    return x, trade_off.predict(x[None, :])[0]

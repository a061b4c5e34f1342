"""pymoo's NSGA-II with its Python loops over individuals replaced by array operations.

The algorithm is pymoo's and so is its sorting (moocore's). Of the time of a generation of 1000,
most went into comparing pairs one by one and into a distance matrix that looks for duplicates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.duplicate import DuplicateElimination
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.selection.tournament import TournamentSelection


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

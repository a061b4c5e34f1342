"""How a study's choices scatter over the seeds, and the rates of least scatter (Fig. 8)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dolfingrip.design.optimum.study import StudyChoice


class Combination(NamedTuple):
    """Mean and scatter over the seeds of what one combination of hyperparameters chose.

    ``mean`` and ``sd`` have shape (inputs,); the deviation is that of a sample (n − 1). Seeds whose
    front had no point within the limit count in ``seeds`` and not in ``chose``.
    """

    population: int
    generations: int
    crossover: float
    mutation: float
    seeds: int
    chose: int
    mean: npt.NDArray[np.float64]
    sd: npt.NDArray[np.float64]
    mean_improved: float


def combine(choices: Iterable[StudyChoice], inputs: int = 2) -> list[Combination]:
    """Return mean and standard deviation over the seeds of each combination.

    Args:
        choices: of all runs.
        inputs: number of inputs of a design.

    Returns:
        The combinations, in the order of their first choice.
    """
    groups: dict[tuple[int, int, float, float], list[StudyChoice]] = defaultdict(list)
    for choice in choices:
        groups[choice[:4]].append(choice)
    return [_combined(key, group, inputs) for key, group in groups.items()]


def _combined(
    key: tuple[int, int, float, float], group: Sequence[StudyChoice], inputs: int
) -> Combination:
    designs = np.array([choice.design for choice in group if choice.design is not None])
    improved = [choice.values[1] for choice in group if choice.values is not None]
    mean = sd = np.full(inputs, np.nan)
    if len(designs) > 0:
        mean = designs.mean(axis=0)
    if len(designs) > 1:
        sd = designs.std(axis=0, ddof=1)
    average = float(np.mean(improved)) if improved else float("nan")
    return Combination(*key, len(group), len(designs), mean, sd, average)


def best(combinations: Iterable[Combination]) -> list[Combination]:
    """Return the rates of least scatter for each population and number of generations.

    It is the scatter of the first input (ξ1) alone, as in the paper. Combinations where some seed
    chose nothing do not take part: their scatter is that of the seeds that happened to succeed.

    Args:
        combinations: that are compared.

    Returns:
        One for each population and number of generations.
    """
    groups: dict[tuple[int, int], list[Combination]] = defaultdict(list)
    for combination in combinations:
        if combination.chose == combination.seeds and np.isfinite(combination.sd[0]):
            groups[combination[:2]].append(combination)
    return [min(group, key=lambda one: one.sd[0]) for _, group in sorted(groups.items())]


def rows(
    combinations: Iterable[Combination], inputs: Sequence[str], improved: str
) -> list[dict[str, object]]:
    """Write combinations as rows of a table, a column for each input's mean and deviation.

    Args:
        combinations: to be written.
        inputs: names of the inputs.
        improved: title of the improved objective.

    Returns:
        The rows.
    """
    table = []
    for one in combinations:
        row: dict[str, object] = dict(list(one._asdict().items())[:6])
        for name, mean, sd in zip(inputs, one.mean, one.sd, strict=True):
            row[f"{name}_mean"], row[f"{name}_sd"] = float(mean), float(sd)
        table.append({**row, f"mean_{improved}": one.mean_improved})
    return table

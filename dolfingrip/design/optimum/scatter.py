"""How a study's choices scatter over the seeds, and the rates of least scatter (Fig. 8)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dolfingrip.design.optimum.study import Choice


class Combination(NamedTuple):
    """Mean and scatter over the seeds of what one combination of hyperparameters chose.

    ``mean`` and ``sd`` have shape (inputs,); the deviation is that of a sample (n − 1). Seeds whose
    front had no point within the COG limit count in ``seeds`` and not in ``chose``.
    """

    population: int
    generations: int
    crossover: float
    mutation: float
    seeds: int
    chose: int
    mean: npt.NDArray[np.float64]
    sd: npt.NDArray[np.float64]
    mean_force_N: float


def combine(choices: Iterable[Choice], inputs: int = 2) -> list[Combination]:
    """Mean and standard deviation over the seeds of each combination, of that many inputs."""
    groups: dict[tuple[int, int, float, float], list[Choice]] = defaultdict(list)
    for choice in choices:
        groups[choice[:4]].append(choice)
    return [_combined(key, group, inputs) for key, group in groups.items()]


def _combined(
    key: tuple[int, int, float, float], group: Sequence[Choice], inputs: int
) -> Combination:
    designs = np.array([choice.design for choice in group if choice.design is not None])
    forces = [choice.force_N for choice in group if choice.force_N is not None]
    mean = sd = np.full(inputs, np.nan)
    if len(designs) > 0:
        mean = designs.mean(axis=0)
    if len(designs) > 1:
        sd = designs.std(axis=0, ddof=1)
    force = float(np.mean(forces)) if forces else float("nan")
    return Combination(*key, len(group), len(designs), mean, sd, force)


def best(combinations: Iterable[Combination]) -> list[Combination]:
    """The rates of least scatter for each population and number of generations.

    As in the paper, of the first input (ξ1) alone. Combinations where some seed chose nothing do
    not take part: their scatter is that of the seeds that happened to succeed.
    """
    groups: dict[tuple[int, int], list[Combination]] = defaultdict(list)
    for combination in combinations:
        if combination.chose == combination.seeds and np.isfinite(combination.sd[0]):
            groups[combination[:2]].append(combination)
    return [min(group, key=lambda one: one.sd[0]) for _, group in sorted(groups.items())]


def rows(combinations: Iterable[Combination], inputs: Sequence[str]) -> list[dict[str, object]]:
    """Combinations as rows of a table, a column for each input's mean and deviation."""
    table = []
    for one in combinations:
        row: dict[str, object] = dict(list(one._asdict().items())[:6])
        for name, mean, sd in zip(inputs, one.mean, one.sd, strict=True):
            row[f"{name}_mean"], row[f"{name}_sd"] = float(mean), float(sd)
        table.append({**row, "mean_force_N": one.mean_force_N})
    return table

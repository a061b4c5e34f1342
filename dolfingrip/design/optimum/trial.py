"""One trial of the hyperparameter study: a run of NSGA-II and its choices, as a job."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final

from dolfingrip.design.optimum.genetic import Settings
from dolfingrip.design.optimum.pareto import fronts, objectives
from dolfingrip.design.surrogate import surrogate as network
from dolfingrip.jobs.job import Data

FUNCTION: Final = "dolfingrip.design.optimum.trial:run"
"""Import path of :func:`run`."""


def run(
    surrogate: str,
    cog_max_mm: float,
    generations: Sequence[int],
    population: int,
    crossover: float,
    mutation: float,
    seed: int,
) -> Data:
    """Run NSGA-II and choose by the COG limit after several numbers of generations.

    Args:
        surrogate: its folder.
        cog_max_mm: the limit.
        generations: after which a design is chosen.
        population, crossover, mutation, seed: as of :class:`~.genetic.Settings`.

    Returns:
        ``cpu_s`` of this process, and ``choices``: for each number of generations its
        ``generations``, the ``front_points``, and the chosen ``design``, ``cog_offset_mm`` and
        ``force_N``, each null where no point of the front is within the limit.
    """
    start = time.process_time()
    model = _load(surrogate)
    settings = Settings(population, max(generations), crossover, mutation, seed)
    found = fronts(objectives(model), model.inputs.low, model.inputs.high, settings, generations)
    choices = []
    for number, front in found.items():
        chosen = front.choose(cog_max_mm)
        none = chosen is None
        choices.append(
            {
                "generations": number,
                "front_points": len(front),
                "design": None if none else front.designs[chosen].tolist(),
                "cog_offset_mm": None if none else float(front.cog_mm[chosen]),
                "force_N": None if none else float(front.force_N[chosen]),
            }
        )
    return {"choices": choices, "cpu_s": time.process_time() - start}


@cache
def _load(folder: str) -> network.Surrogate:
    return network.load(Path(folder))

"""One trial of the hyperparameter study, and the process that does them (``python -m``)."""

from __future__ import annotations

import time
from functools import cache
from pathlib import Path
from typing import Any

import torch

from dolfingrip.design.optimum import workers
from dolfingrip.design.optimum.pareto import Settings, fronts, objectives
from dolfingrip.design.surrogate import surrogate


def run(job: dict[str, Any]) -> dict[str, Any]:
    """Run NSGA-II and choose by the COG limit after several numbers of generations.

    Args:
        job: ``surrogate`` (its folder), ``cog_max_mm``, ``population``, ``generations`` (a list),
            ``crossover``, ``mutation``, ``seed``.

    Returns:
        ``cpu_s`` of this process, and ``choices``: for each number of generations its
        ``generations``, the ``front_points``, and the chosen ``design``, ``cog_offset_mm`` and
        ``force_N``, each null where no point of the front is within the limit.
    """
    start = time.process_time()
    model = _load(job["surrogate"])
    settings = Settings(
        job["population"], max(job["generations"]), job["crossover"], job["mutation"], job["seed"]
    )
    found = fronts(
        objectives(model), model.inputs.low, model.inputs.high, settings, job["generations"]
    )
    choices = []
    for generations, front in found.items():
        chosen = front.choose(job["cog_max_mm"])
        none = chosen is None
        choices.append(
            {
                "generations": generations,
                "front_points": len(front),
                "design": None if none else front.designs[chosen].tolist(),
                "cog_offset_mm": None if none else float(front.cog_mm[chosen]),
                "force_N": None if none else float(front.force_N[chosen]),
            }
        )
    return {"choices": choices, "cpu_s": time.process_time() - start}


@cache
def _load(folder: str) -> surrogate.Surrogate:
    return surrogate.load(Path(folder))


if __name__ == "__main__":
    torch.set_num_threads(1)  # the study fills the cores with processes
    workers.serve(run)

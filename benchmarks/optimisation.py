"""Time of NSGA-II on a surrogate, and of the hyperparameter study.

    scripts/run python -m benchmarks.optimisation out/surrogate

Times are of the processor, so that a busy machine does not count.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import torch

from dolfingrip.design.optimum import trial
from dolfingrip.design.optimum.pareto import Settings, fronts, objectives
from dolfingrip.design.optimum.study import Plan
from dolfingrip.design.optimum.trials import Key
from dolfingrip.design.surrogate import surrogate

ALLOWED_S = 15.0
"""For the paper's population and generations."""


def paper(folder: Path) -> float:
    """Seconds of one run with the paper's population and generations."""
    model = surrogate.load(folder)
    start = time.process_time()
    fronts(objectives(model), model.inputs.low, model.inputs.high, Settings())
    return time.process_time() - start


def study(folder: Path, plan: Plan) -> float:
    """Seconds of a whole study on one core, from one seed of each population and pair of rates."""
    common = {"surrogate": str(folder), "cog_max_mm": plan.cog_max_mm}
    total = 0.0
    for key in Plan(plan.populations, plan.generations, plan.crossovers, plan.mutations, 1).runs():
        job = {**common, "generations": list(plan.generations), **key._asdict()}
        taken = trial.run(job)["cpu_s"]
        print(f"{_name(key)}: {taken:.1f} s", flush=True)
        total += taken
    return total * plan.seeds


def _name(key: Key) -> str:
    return f"population {key.population}, crossover {key.crossover:g}, mutation {key.mutation:g}"


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("surrogate", type=Path, help="folder of a trained surrogate")
    parser.add_argument("--study", action="store_true", help="estimate the study's time, too")
    asked = parser.parse_args()
    torch.set_num_threads(1)
    print(f"population 1000, 200 generations: {paper(asked.surrogate):.1f} s of {ALLOWED_S:g} s")
    if asked.study:
        seconds = study(asked.surrogate, Plan())
        print(f"the whole study: {seconds / 60:.0f} minutes of one core")


if __name__ == "__main__":
    main()

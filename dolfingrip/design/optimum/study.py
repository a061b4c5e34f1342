"""The study of NSGA-II's hyperparameters: the runs of the paper's Table 1 (section IV.B)."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from dolfingrip.design.optimum import workers
from dolfingrip.design.optimum.pareto import objectives
from dolfingrip.design.optimum.trials import Choice, Key, Trials
from dolfingrip.design.surrogate import surrogate

STORE = "study.sqlite"


@dataclass(frozen=True)
class Plan:
    """What is tried: every combination of these, each with several seeds. Defaults: Table 1."""

    populations: tuple[int, ...] = (50, 100, 500, 1000)
    generations: tuple[int, ...] = (10, 50, 100, 200)
    crossovers: tuple[float, ...] = (0.9, 0.8, 0.6, 0.4)
    mutations: tuple[float, ...] = (0.01, 0.1, 0.5, 0.8)
    seeds: int = 10
    cog_max_mm: float = 3.0

    def runs(self) -> list[Key]:
        """The runs to do, the longest first, so that no core waits for one at the end.

        A run of the most generations gives the choices after fewer, too (see ``pareto.fronts``),
        so generations do not multiply their number.
        """
        order = itertools.product(
            sorted(self.populations, reverse=True),
            sorted(self.mutations),  # little mutation makes copies, which NSGA-II replaces
            sorted(self.crossovers),
            range(1, self.seeds + 1),
        )
        return [
            Key(population, crossover, mutation, seed)
            for population, mutation, crossover, seed in order
        ]


class Finished(NamedTuple):
    """A plan's choices in the order of their keys, and the processor time of all stored runs."""

    choices: list[Choice]
    cpu_s: float


def run(
    folder: Path,
    out: Path,
    plan: Plan,
    processes: int = 2,
    progress: Callable[[int, int], None] | None = None,
) -> Finished:
    """Do the runs that are not in ``out`` yet.

    Args:
        folder: of the surrogate.
        out: folder of the study; what a killed study finished is kept there.
        plan: what to try.
        processes: one core each.
        progress: called with the runs done and the number of all.

    Returns:
        The plan's choices; those of other plans stay in the folder.

    Raises:
        ConfigError: no surrogate there, or ``out`` holds a study of something else.
        WorkerDied: a process ended early; the rest can be resumed.
    """
    model = surrogate.load(folder)
    objectives(model)  # complains in one line where it lacks one
    identity = {
        "surrogate": model.sha256(),
        "cog_max_mm": plan.cog_max_mm,
        "pymoo": metadata.version("pymoo"),
    }
    out.mkdir(parents=True, exist_ok=True)
    trials = Trials(out / STORE, identity)
    try:
        runs = plan.runs()
        done = trials.done(plan.generations)
        left = [key for key in runs if key not in done]
        if progress is not None:
            progress(len(runs) - len(left), len(runs))
        common = {
            "surrogate": str(folder.resolve()),
            "cog_max_mm": plan.cog_max_mm,
            "generations": list(plan.generations),
        }
        jobs = ({**common, **key._asdict()} for key in left)
        finished = workers.run("dolfingrip.design.optimum.trial", jobs, processes)
        for count, (job, result) in enumerate(finished, len(runs) - len(left) + 1):
            trials.add(Key(*(job[name] for name in Key._fields)), result)
            if progress is not None:
                progress(count, len(runs))
        wanted = set(runs)
        choices = [
            choice
            for choice in trials.choices()
            if Key(choice.population, choice.crossover, choice.mutation, choice.seed) in wanted
            and choice.generations in plan.generations
        ]
        return Finished(choices, trials.seconds())
    finally:
        trials.close()

"""The study of NSGA-II's hyperparameters: the runs of the paper's Table 1 (section IV.B)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from dolfingrip.design.optimum.pareto import objectives
from dolfingrip.design.optimum.trial import FUNCTION
from dolfingrip.design.surrogate import surrogate
from dolfingrip.jobs import run as jobs
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import Data, Job, content_key
from dolfingrip.jobs.pool import Pool, Unfinished
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.jobs.store import NAME, Store, same


class Key(NamedTuple):
    """The settings that identify a run of NSGA-II."""

    population: int
    crossover: float
    mutation: float
    seed: int


class Choice(NamedTuple):
    """The design chosen after some generations of a run; None throughout where there was none."""

    population: int
    generations: int
    crossover: float
    mutation: float
    seed: int
    front_points: int
    design: tuple[float, ...] | None
    cog_offset_mm: float | None
    force_N: float | None


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
    folder: Path, out: Path, plan: Plan, processes: int = 2, progress: Progress = silent
) -> Finished:
    """Do the runs that are not in ``out`` yet.

    Args:
        folder: of the surrogate.
        out: folder of the study; what a killed study finished is kept there.
        plan: what to try.
        processes: one core each.
        progress: called at the start and with each run stored.

    Returns:
        The plan's choices; those of other plans stay in the folder.

    Raises:
        ConfigError: no surrogate there, or ``out`` holds a study of something else.
        Unfinished: runs failed, as where workers died; the same call tries these again.
    """
    model = surrogate.load(folder)
    objectives(model)  # complains in one line where it lacks one
    identity = {
        "surrogate": model.sha256(),
        "cog_max_mm": plan.cog_max_mm,
        "pymoo": metadata.version("pymoo"),
    }
    common = {"surrogate": str(folder.resolve()), "cog_max_mm": plan.cog_max_mm}
    wider = _wider(out, plan)
    wanted = []
    for key in plan.runs():
        inputs = {**key._asdict(), "generations": wider.get(key, plan.generations)}
        wanted.append(
            Job(content_key({**identity, **inputs}), FUNCTION, {**common, **inputs}, inputs)
        )
    with Pool(Where(workers=processes)) as pool:
        standing = jobs.run(
            wanted, out, pool, same(**identity), retry_failed=True, progress=progress
        )
    with Store(out) as store:
        rows = {row["key"]: row for row in store.rows()}
    if standing.failed:
        failure = next(row["failure"] for job in wanted if (row := rows[job.key])["failure"])
        raise Unfinished(
            f"{standing.failed} of {standing.total} runs failed: {failure}; the others are kept, "
            "the same call tries these again"
        )
    choices = sorted(
        choice
        for job in wanted
        for choice in _choices(rows[job.key])
        if choice.generations in plan.generations
    )
    done = [row for row in rows.values() if row["status"] == "done"]
    return Finished(choices, sum(row["result"]["cpu_s"] for row in done))


def _wider(out: Path, plan: Plan) -> dict[Key, tuple[int, ...]]:
    """Generations of the runs that are done and have the plan's generations among theirs."""
    if not (out / NAME).is_file():
        return {}
    with Store(out) as store:
        done = [row["inputs"] for row in store.rows() if row["status"] == "done"]
    return {
        _key(inputs): tuple(inputs["generations"])
        for inputs in done
        if set(plan.generations) <= set(inputs["generations"])
    }


def _key(inputs: Mapping[str, Any]) -> Key:
    return Key(*(inputs[name] for name in Key._fields))


def _choices(row: Data) -> Iterator[Choice]:
    """The choices of a run that is done."""
    for found in row["result"]["choices"]:
        design = found["design"]
        values = {**row["inputs"], **found, "design": None if design is None else tuple(design)}
        yield Choice(*(values[name] for name in Choice._fields))

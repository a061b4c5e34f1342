"""The study of NSGA-II's hyperparameters: the runs of the paper's Table 1 (section IV.B).

Choices scatter over the seeds; the rates of least scatter are the best (Fig. 8).
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from dolfingrip.design.optimum.pareto import NSGA2Settings, TradeOff, fronts
from dolfingrip.design.surrogate import surrogate as network
from dolfingrip.files.objective import NamedObjective
from dolfingrip.jobs import run as jobs
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import Data, Job, content_key
from dolfingrip.jobs.pool import Pool, Unfinished
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.jobs.store import NAME, Store, same

FUNCTION: Final = "dolfingrip.design.optimum.study:trial"
"""Import path of :func:`trial`."""


class Key(NamedTuple):
    """The settings that identify a run of NSGA-II."""

    population: int
    crossover: float
    mutation: float
    seed: int


class StudyChoice(NamedTuple):
    """The design chosen after some generations of a run, with its objectives; None: none was."""

    population: int
    generations: int
    crossover: float
    mutation: float
    seed: int
    design: tuple[float, ...] | None
    values: tuple[float, float] | None


@dataclass(frozen=True)
class HyperparameterStudy:
    """Every combination of these settings of NSGA-II, each with several seeds.

    The defaults are those of the paper's Table 1.

    Attributes:
        objectives: the limited one, the improved one.
        limit: of the first objective, that a design is chosen by.
        populations, generations, crossovers, mutations: of :class:`~.genetic.NSGA2Settings`.
        seeds: number of runs of each.
    """

    objectives: tuple[NamedObjective, NamedObjective]
    limit: float

    populations: tuple[int, ...] = (50, 100, 500, 1000)
    generations: tuple[int, ...] = (10, 50, 100, 200)
    crossovers: tuple[float, ...] = (0.9, 0.8, 0.6, 0.4)
    mutations: tuple[float, ...] = (0.01, 0.1, 0.5, 0.8)
    seeds: int = 10

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

    choices: list[StudyChoice]
    cpu_s: float


def run(
    folder: Path,
    out: Path,
    plan: HyperparameterStudy,
    processes: int = 2,
    progress: Progress = silent,
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
    model = network.load(folder)
    TradeOff.of(model, plan.objectives)  # complains in one line where the model lacks one
    goal = {"objectives": [o.model_dump() for o in plan.objectives], "limit": plan.limit}
    identity = {
        "surrogate": model.sha256(),
        "objectives": ", ".join(f"{o.sense} {o.title}" for o in plan.objectives),
        "limit": plan.limit,
        "pymoo": metadata.version("pymoo"),
    }
    common = {"surrogate": str(folder.resolve()), **goal}
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


def _wider(out: Path, plan: HyperparameterStudy) -> dict[Key, tuple[int, ...]]:
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


def _choices(row: Data) -> Iterator[StudyChoice]:
    """The choices of a run that is done."""
    for choice in row["result"]["choices"]:
        pairs = {name: choice[name] and tuple(choice[name]) for name in ("design", "values")}
        values = {**row["inputs"], **choice, **pairs}
        yield StudyChoice(*(values[name] for name in StudyChoice._fields))


def trial(
    surrogate: str,
    objectives: Sequence[Data],
    limit: float,
    generations: Sequence[int],
    population: int,
    crossover: float,
    mutation: float,
    seed: int,
) -> Data:
    """Run NSGA-II, as a job, and choose by the limit after several numbers of generations.

    Args:
        surrogate: its folder.
        objectives: plain data of the two objectives.
        limit: of the first objective.
        generations: after which a design is chosen.
        population, crossover, mutation, seed: as of :class:`~.genetic.NSGA2Settings`.

    Returns:
        ``cpu_s`` of this process, and ``choices``: for each number of generations its
        ``generations``, the ``front_points``, and the chosen ``design`` with the ``values`` of its
        objectives, each null where no point of the front is within the limit.
    """
    start = time.process_time()
    named = [NamedObjective.model_validate(o) for o in objectives]
    settings = NSGA2Settings(population, max(generations), crossover, mutation, seed)
    choices = []
    for number, front in fronts(
        TradeOff.of(_loaded(Path(surrogate)), named), settings, generations
    ).items():
        chosen = front.choose(limit)
        choices.append(
            {
                "generations": number,
                "front_points": len(front),
                "design": None if chosen is None else front.designs[chosen].tolist(),
                "values": None if chosen is None else front.values[chosen].tolist(),
            }
        )
    return {"choices": choices, "cpu_s": time.process_time() - start}


_loaded = cache(network.load)

SETTINGS: Final = ["population", "generations", "crossover", "mutation"]
"""Columns of a combination of hyperparameters."""


def combine(choices: Iterable[StudyChoice], inputs: Sequence[str], improved: str) -> pd.DataFrame:
    """Return mean and standard deviation over the seeds of each combination.

    The deviation is that of a sample (n − 1). Seeds whose front had no point within the limit count
    in ``seeds`` and not in ``chose``.

    Args:
        choices: of all runs.
        inputs: names of a design's inputs.
        improved: title of the improved objective.

    Returns:
        A row for each combination, in the order of their first choice.
    """
    none = (np.nan,) * len(inputs)
    made = pd.DataFrame(
        [(*c[:4], *(c.design or none), c.values[1] if c.values else np.nan) for c in choices],
        columns=[*SETTINGS, *inputs, improved],
    )
    groups = made.groupby(SETTINGS, sort=False)
    columns = {"seeds": groups.size(), "chose": groups[inputs[0]].count()}
    for name in inputs:
        columns |= {f"{name}_mean": groups[name].mean(), f"{name}_sd": groups[name].std()}
    columns[f"mean_{improved}"] = groups[improved].mean()
    return pd.DataFrame(columns).reset_index()


def best(combinations: pd.DataFrame, first: str) -> pd.DataFrame:
    """Return the rates of least scatter for each population and number of generations.

    It is the scatter of the first input (ξ1) alone, as in the paper. Combinations where some seed
    chose nothing do not take part: their scatter is that of the seeds that happened to succeed.

    Args:
        combinations: that are compared.
        first: name of the first input.

    Returns:
        One for each population and number of generations.
    """
    scatter = f"{first}_sd"
    sure = combinations[(combinations["chose"] == combinations["seeds"])].dropna(subset=[scatter])
    return sure.loc[sure.groupby(SETTINGS[:2])[scatter].idxmin()]

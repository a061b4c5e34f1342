"""The hyperparameter study: resumed after a kill, and the same as if it had not been killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest
from support.stand_in import OBJECTIVES

from dolfingrip.config import ConfigError
from dolfingrip.design.optimum import study
from dolfingrip.design.optimum.pareto import NSGA2Settings, TradeOff, fronts
from dolfingrip.design.optimum.study import HyperparameterStudy, StudyChoice
from dolfingrip.design.surrogate import surrogate
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.jobs.run import Standing
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import NAME, Store

PAPER = HyperparameterStudy(OBJECTIVES, 3.0)
SMALL = replace(
    PAPER,
    populations=(20, 40),
    generations=(5, 10),
    crossovers=(0.9,),
    mutations=(0.1, 0.5),
    seeds=2,
)


def test_table_1() -> None:
    plan = PAPER
    runs = plan.runs()
    # 64 × 10 runs hold the 256 × 10 trials, four numbers of generations in each
    assert len(set(runs)) == len(runs) == 640
    assert len(runs) * len(plan.generations) == 2560


def test_a_trial_is_the_front_it_says(surrogate_folder: Path) -> None:
    job = {
        "surrogate": str(surrogate_folder), "limit": 3.0,
        "objectives": [each.model_dump() for each in OBJECTIVES], "generations": [5, 10],
        "population": 30, "crossover": 0.6, "mutation": 0.1, "seed": 4,
    }  # fmt: skip
    short, long = study.trial(**job)["choices"]
    model = surrogate.load(surrogate_folder)
    found = fronts(TradeOff.of(model, OBJECTIVES), NSGA2Settings(30, 5, 0.6, 0.1, 4))[5]
    place = found.choose(3.0)
    assert place is not None
    assert short["design"] == found.designs[place].tolist()
    assert short["values"] == found.values[place].tolist()
    assert (short["generations"], long["generations"]) == (5, 10)
    nothing = study.trial(**{**job, "limit": -5.0})["choices"][0]
    assert nothing["design"] is None
    assert nothing["values"] is None


STUDY = """
import sys
from pathlib import Path
from dolfingrip.design.optimum import study
from dolfingrip.design.quantities.quantity import objective
pair = (objective("cog_offset_mm", "at most"), objective("force_N", "maximise"))
plan = study.HyperparameterStudy(pair, 3.0, (20, 40), (5, 10), (0.9,), (0.1, 0.5), 2)
show = lambda standing: print(standing.done, flush=True)
study.run(Path(sys.argv[1]), Path(sys.argv[2]), plan, 1, show)
"""


class Seen(list[int]):
    """Numbers of runs done, as they are shown."""

    def __call__(self, standing: Standing) -> None:
        self.append(standing.done)


def done(folder: Path) -> dict[str, dict[str, Any]]:
    """Rows of the runs that are done, by key."""
    with Store(folder) as store:
        return {row["key"]: row for row in store.rows() if row["status"] == "done"}


@pytest.mark.slow
@pytest.mark.usefixtures("threads")  # the study that is killed has processes
def test_a_killed_study_is_resumed(surrogate_folder: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-c", STUDY, str(surrogate_folder), str(tmp_path / "killed")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as killed:
        assert killed.stdout is not None
        while int(killed.stdout.readline()) < 3:
            pass
        workers = psutil.Process(killed.pid).children(recursive=True)
        os.kill(killed.pid, signal.SIGKILL)
    assert workers
    assert psutil.wait_procs(workers, timeout=20)[1] == []  # they end with their parent
    kept = done(tmp_path / "killed")
    assert 3 <= len(kept) < 8
    for row in kept.values():  # whole runs only
        assert [each["generations"] for each in row["result"]["choices"]] == [5, 10]
    spooled = {answer.key for answer in Spool(tmp_path / "killed" / "spool").answers()}
    seen = Seen()
    resumed = study.run(surrogate_folder, tmp_path / "killed", SMALL, 2, seen).choices
    assert seen[0] == len(kept.keys() | spooled)
    assert seen[-1] == 8
    after = done(tmp_path / "killed")
    assert {key: after[key] for key in kept} == kept  # none was done again: times would differ
    assert len(resumed) == 16
    for choice in resumed:  # as if it had run in one go
        alone = study.trial(
            str(surrogate_folder), [each.model_dump() for each in OBJECTIVES], 3.0,
            SMALL.generations, choice.population, choice.crossover, choice.mutation, choice.seed,
        )["choices"][SMALL.generations.index(choice.generations)]  # fmt: skip
        assert choice.design == tuple(alone["design"])


@pytest.mark.usefixtures("threads")
def test_a_wider_plan_keeps_what_there_is(surrogate_folder: Path, tmp_path: Path) -> None:
    tiny = HyperparameterStudy(OBJECTIVES, 3.0, (20,), (3, 4), (0.9,), (0.5,), 1)
    study.run(surrogate_folder, tmp_path, tiny, 1)
    first = Seen()
    wider = HyperparameterStudy(OBJECTIVES, 3.0, (20,), (3, 4), (0.9, 0.8), (0.5,), 1)
    found = study.run(surrogate_folder, tmp_path, wider, 1, first)
    assert first == [1, 2]
    assert [(choice.generations, choice.crossover) for choice in found.choices] == [
        (3, 0.8), (3, 0.9), (4, 0.8), (4, 0.9),
    ]  # fmt: skip
    assert found.cpu_s == pytest.approx(
        sum(row["result"]["cpu_s"] for row in done(tmp_path).values())
    )
    again = Seen()
    assert len(study.run(surrogate_folder, tmp_path, tiny, 1, again).choices) == 2
    # fewer generations are among those of the longer run, more are not
    few = study.run(surrogate_folder, tmp_path, replace(tiny, generations=(4,)), 1, again)
    assert again == [1, 1]
    assert few.choices == [found.choices[3]]
    more = Seen()
    study.run(surrogate_folder, tmp_path, replace(tiny, generations=(4, 5)), 1, more)
    assert more == [0, 1]


@pytest.mark.usefixtures("threads")
def test_another_limit_is_another_study(surrogate_folder: Path, tmp_path: Path) -> None:
    tiny = HyperparameterStudy(OBJECTIVES, 3.0, (20,), (3,), (0.9,), (0.5,), 1)
    study.run(surrogate_folder, tmp_path, tiny, 1)
    with pytest.raises(ConfigError, match=r"limit was 3\.0, now 3\.5; allowed: the same"):
        study.run(surrogate_folder, tmp_path, replace(tiny, limit=3.5), 1)
    other = tmp_path / "other"
    other.mkdir()
    (other / NAME).write_text("text, and long enough not to be taken for an empty file")
    with pytest.raises(ConfigError, match="not a campaign's store"):
        study.run(surrogate_folder, other, tiny, 1)


@pytest.mark.slow
def test_a_dead_worker_is_told(
    surrogate_folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> None:
    """And the next call tries again what it was doing."""
    tiny = HyperparameterStudy(OBJECTIVES, 3.0, (20,), (3,), (0.9,), (0.5,), 1)
    monkeypatch.setattr(study, "FUNCTION", "support.analytic:dies")
    with pytest.raises(Unfinished, match=r"1 of 1 could not be computed .*: every worker"):
        study.run(surrogate_folder, tmp_path, tiny, 1)
    monkeypatch.undo()
    request.getfixturevalue("threads")
    assert len(study.run(surrogate_folder, tmp_path, tiny, 1).choices) == 1


def _choices(crossover: float, designs: list[tuple[float, float] | None]) -> list[StudyChoice]:
    return [
        StudyChoice(50, 10, crossover, 0.5, seed, design, (2.9, 6.0 + seed))
        for seed, design in enumerate(designs)
    ]


def test_mean_deviation_and_best_rates() -> None:
    steady = _choices(0.9, [(0.1, -0.2), (0.2, -0.4), (0.3, -0.6)])
    lucky = _choices(0.8, [(0.2, -0.4), None, (0.2, -0.4)])  # no scatter, but not every seed chose
    wild = _choices(0.4, [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)])
    names = ("morph.xi1", "morph.xi2")
    combined = study.combine([*steady, *lucky, *wild], names, "force_N")
    first = combined.iloc[0]
    assert [first[f"{name}_mean"] for name in names] == pytest.approx([0.2, -0.4])
    assert [first[f"{name}_sd"] for name in names] == pytest.approx([0.1, 0.2])  # n − 1
    assert first["mean_force_N"] == 7.0
    assert [*zip(combined["seeds"], combined["chose"], strict=True)] == [(3, 3), (3, 2), (3, 3)]
    assert [*study.best(combined, names[0])["crossover"]] == [0.9]
    nothing = study.combine(_choices(0.9, [None, None]), names, "force_N")
    assert study.best(nothing, names[0]).empty

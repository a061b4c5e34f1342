"""The hyperparameter study: resumed after a kill, and the same as if it had not been killed."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import ConfigError
from dolfingrip.design.optimum import scatter, study, trial, workers
from dolfingrip.design.optimum.pareto import Settings, fronts, objectives
from dolfingrip.design.optimum.study import Plan
from dolfingrip.design.optimum.trials import Choice, Key, Trials
from dolfingrip.design.surrogate import surrogate

SMALL = Plan(
    populations=(20, 40), generations=(5, 10), crossovers=(0.9,), mutations=(0.1, 0.5), seeds=2
)


def test_table_1() -> None:
    plan = Plan()
    runs = plan.runs()
    # 64 × 10 runs hold the 256 × 10 trials, four numbers of generations in each
    assert len(set(runs)) == len(runs) == 640
    assert len(runs) * len(plan.generations) == 2560


def test_a_trial_is_the_front_it_says(surrogate_folder: Path) -> None:
    job = {
        "surrogate": str(surrogate_folder), "cog_max_mm": 3.0, "generations": [5, 10],
        "population": 30, "crossover": 0.6, "mutation": 0.1, "seed": 4,
    }  # fmt: skip
    short, long = trial.run(job)["choices"]
    model = surrogate.load(surrogate_folder)
    found = fronts(
        objectives(model), model.inputs.low, model.inputs.high, Settings(30, 5, 0.6, 0.1, 4)
    )[5]
    place = found.choose(3.0)
    assert place is not None
    assert short["design"] == found.designs[place].tolist()
    assert short["force_N"] == found.force_N[place]
    assert (short["generations"], long["generations"]) == (5, 10)
    nothing = trial.run({**job, "cog_max_mm": -5.0})["choices"][0]
    assert nothing["design"] is None
    assert nothing["force_N"] is None


STUDY = """
import sys
from pathlib import Path
from dolfingrip.design.optimum import study
plan = study.Plan((20, 40), (5, 10), (0.9,), (0.1, 0.5), 2)
study.run(Path(sys.argv[1]), Path(sys.argv[2]), plan, 1, lambda done, _: print(done, flush=True))
"""


def test_a_killed_study_is_resumed(surrogate_folder: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-c", STUDY, str(surrogate_folder), str(tmp_path / "killed")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as killed:
        assert killed.stdout is not None
        while int(killed.stdout.readline()) < 3:
            pass
        os.kill(killed.pid, signal.SIGKILL)
    with sqlite3.connect(tmp_path / "killed" / study.STORE) as connection:
        kept = connection.execute("SELECT rowid, * FROM choice").fetchall()
    connection.close()
    assert 3 * 2 <= len(kept) < 8 * 2
    assert len(kept) % 2 == 0  # whole trials only
    done: list[int] = []
    resumed = study.run(
        surrogate_folder, tmp_path / "killed", SMALL, 2, lambda number, _: done.append(number)
    ).choices
    assert done[0] == len(kept) // 2
    assert done[-1] == 8
    with sqlite3.connect(tmp_path / "killed" / study.STORE) as connection:
        after = connection.execute("SELECT rowid, * FROM choice").fetchall()
    connection.close()
    assert set(kept) <= set(after)  # none was done again: times would differ
    assert len(resumed) == 16
    for choice in resumed:  # as if it had run in one go
        job = {
            **choice._asdict(), "generations": list(SMALL.generations),
            "surrogate": str(surrogate_folder), "cog_max_mm": SMALL.cog_max_mm,
        }  # fmt: skip
        alone = trial.run(job)["choices"][SMALL.generations.index(choice.generations)]
        assert choice.design == tuple(alone["design"])


def test_a_wider_plan_keeps_what_there_is(surrogate_folder: Path, tmp_path: Path) -> None:
    tiny = Plan((20,), (3,), (0.9,), (0.5,), 1)
    study.run(surrogate_folder, tmp_path, tiny, 1)
    first: list[int] = []
    wider = Plan((20,), (3,), (0.9, 0.8), (0.5,), 1)
    found = study.run(surrogate_folder, tmp_path, wider, 1, lambda done, _: first.append(done))
    assert first == [1, 2]
    assert [choice.crossover for choice in found.choices] == [0.8, 0.9]
    assert len(study.run(surrogate_folder, tmp_path, tiny, 1).choices) == 1


def test_another_limit_is_another_study(surrogate_folder: Path, tmp_path: Path) -> None:
    tiny = Plan((20,), (3,), (0.9,), (0.5,), 1)
    study.run(surrogate_folder, tmp_path, tiny, 1)
    with pytest.raises(ConfigError, match="the study of another surrogate or limit"):
        study.run(surrogate_folder, tmp_path, Plan((20,), (3,), (0.9,), (0.5,), 1, 3.5), 1)
    other = tmp_path / "other"
    other.mkdir()
    (other / study.STORE).write_text("text, and long enough not to be taken for an empty file")
    with pytest.raises(ConfigError, match="allowed: the store of a study"):
        Trials(other / study.STORE, {})


def test_a_dead_worker_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken_worker.py").write_text("raise SystemExit('no memory')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(workers.WorkerDied, match="ended with code 1: no memory"):
        list(workers.run("broken_worker", [{"a": 1}], 1))


def test_workers_end_with_their_parent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "slow_worker.py").write_text(
        "import os, time\nfrom dolfingrip.design.optimum import workers\n"
        "workers.serve(lambda job: (time.sleep(0.5), {'pid': os.getpid()})[1])"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    parent = (
        "from dolfingrip.design.optimum import workers\n"
        "for _, result in workers.run('slow_worker', [{}, {}, {}], 1):\n"
        "    print(result['pid'], flush=True)"
    )
    with subprocess.Popen([sys.executable, "-P", "-c", parent], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        worker = int(process.stdout.readline())
        os.kill(process.pid, signal.SIGKILL)
    deadline = time.monotonic() + 20
    while _alive(worker) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not _alive(worker)


def _alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def _choices(crossover: float, designs: list[tuple[float, float] | None]) -> list[Choice]:
    return [
        Choice(50, 10, crossover, 0.5, seed, 50, design, 2.9, 6.0 + seed)
        for seed, design in enumerate(designs)
    ]


def test_mean_deviation_and_best_rates() -> None:
    steady = _choices(0.9, [(0.1, -0.2), (0.2, -0.4), (0.3, -0.6)])
    lucky = _choices(0.8, [(0.2, -0.4), None, (0.2, -0.4)])  # no scatter, but not every seed chose
    wild = _choices(0.4, [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)])
    combined = scatter.combine([*steady, *lucky, *wild])
    first = combined[0]
    np.testing.assert_allclose(first.mean, [0.2, -0.4])
    np.testing.assert_allclose(first.sd, [0.1, 0.2])  # of a sample: n − 1
    assert first.mean_force_N == 7.0
    assert [(one.seeds, one.chose) for one in combined] == [(3, 3), (3, 2), (3, 3)]
    assert [one.crossover for one in scatter.best(combined)] == [0.9]
    row = scatter.rows([first], ["morph.xi1", "morph.xi2"])[0]
    assert row["morph.xi2_sd"] == pytest.approx(0.2)
    assert scatter.best(scatter.combine(_choices(0.9, [None, None]))) == []


def test_keys_and_choices_are_as_stored(tmp_path: Path) -> None:
    trials = Trials(tmp_path / "s.sqlite", {})
    key = Key(20, 0.9, 0.01, 1)
    one = {"front_points": 3, "design": [0.1, 0.2], "cog_offset_mm": 1.0, "force_N": 2.0}
    trials.add(key, {"cpu_s": 1.5, "choices": [{**one, "generations": g} for g in (5, 10)]})
    assert trials.done((5, 10)) == {key}
    assert trials.done((5, 10, 20)) == set()
    assert trials.choices()[0].design == (0.1, 0.2)
    assert trials.seconds() == 1.5
    trials.close()

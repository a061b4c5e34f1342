"""The campaign of many grasps, with an invented grasp in place of the solver's."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks import grasp_sweep
from benchmarks.grasp_sweep import FOOD, PRESSURE
from dolfingrip import config as configuration
from dolfingrip.design.campaign import objective
from dolfingrip.design.quantities import grasp
from dolfingrip.design.quantities.quantity import Outcome
from dolfingrip.jobs.job import JobFailure, JobResult
from dolfingrip.jobs.store import Store
from dolfingrip.jobs.work import compute
from dolfingrip.sections.tables import assignments


def invented(config: dict[str, Any], quantities: tuple[str, ...], ranks: int) -> Outcome:
    """Angles grow with pressure; at 300 kPa a large potato's path fails."""
    pressure = config["experiment"]["max_pressure_kPa"]
    if config["food"]["kind"] == "potato-large" and pressure == 300:
        raise JobFailure("iteration limit", "stopped")
    outputs = dict.fromkeys(quantities, 0.4 * pressure)
    return Outcome(outputs, curve={"outcome": "picked up", "sentence": "lifted"})


def answered(points: list[Any], out: Path, shared: configuration.Config) -> None:
    """Simulations as a campaign's workers would have stored them."""
    plan = grasp_sweep.plan(points, shared)
    out.mkdir()
    with Store(out, write=True) as store:
        store.add(plan.jobs(), plan.shared)
        for job in plan.jobs():
            made_up = {**job.arguments, "objective": f"{__name__}:invented"}
            answer = compute(replace(job, arguments=made_up))
            assert isinstance(JobResult.loads(answer.dumps()), JobResult)
            store.record(answer)


def test_the_sweep_has_twenty_grasps_and_a_picture(tmp_path: Path) -> None:
    shared = configuration.load(None, assignments([]), assignments(grasp_sweep.OURS))
    points = grasp_sweep.points()
    assert len(points) == 20
    out = tmp_path / "sweep"
    answered(points, out, shared)
    rows = grasp_sweep.outcomes(points, shared, out)
    assert len(rows) == 20
    failed = [row for row in rows if row["outcome"].startswith(grasp_sweep.FAILED)]
    assert [(row[FOOD], row[PRESSURE]) for row in failed] == [("potato-large", 300.0)]
    grasp_sweep.publish(rows, grasp_sweep.parsed(["--out", str(out)]))
    assert "19 of 20 end in a class" in (out / "summary.md").read_text(encoding="utf-8")
    assert (out / "grasp_sweep.png").stat().st_size > 1000
    with (out / "grasp_sweep.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert table[0]["angle_A_deg"] == "80"


def test_a_grasp_runs_on_one_rank() -> None:
    with pytest.raises(configuration.ConfigError, match="--ranks 2: allowed: 1"):
        objective.simulate({}, grasp.QUANTITIES, 2)

"""The scripts of many grasps, with an invented grasp in place of the solver's."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.append(str(Path(__file__).resolve().parents[1]))

from benchmarks import grasp_campaign, grasp_sweep, random_grasps
from benchmarks.grasp_campaign import FOOD, FRICTION, POSE, PRESSURE
from dolfingrip import config as configuration
from dolfingrip.design.campaign import grasps
from dolfingrip.design.campaign.answer import Answer, DesignFailure, Outcome
from dolfingrip.design.campaign.evaluate import Task, evaluate
from dolfingrip.design.campaign.store import Store


def invented(config: dict[str, Any], quantities: tuple[str, ...], ranks: int) -> Outcome:
    """Angles grow with pressure; at 300 kPa a large potato's path fails."""
    pressure = config["experiment"]["max_pressure_kPa"]
    if config["food"]["kind"] == "potato-large" and pressure == 300:
        raise DesignFailure("iteration limit", "stopped")
    outputs = dict.fromkeys(quantities, 0.4 * pressure)
    return Outcome(outputs, curve={"outcome": "picked up", "sentence": "lifted"})


def answered(points: list[Any], out: Path, shared: configuration.Config) -> None:
    """What a campaign's workers would have stored."""
    plan = grasp_campaign.plan(points, shared)
    out.mkdir()
    with Store(out, write=True) as store:
        store.add(plan.facts(), plan.designs())
        for design in plan.designs():
            task = Task(
                design.key, design.config, plan.quantities, f"{__name__}:invented", 1, str(out)
            )
            answer = evaluate(task)
            assert isinstance(Answer.loads(answer.dumps()), Answer)
            store.record(answer)


def test_the_sweep_has_twenty_grasps_and_a_picture(tmp_path: Path) -> None:
    shared = configuration.load(None, [], grasp_campaign.OURS)
    points = grasp_sweep.points()
    assert len(points) == 20
    out = tmp_path / "sweep"
    answered(points, out, shared)
    rows = grasp_campaign.outcomes(points, shared, out)
    assert len(rows) == 20
    failed = [row for row in rows if row["outcome"].startswith(grasp_campaign.FAILED)]
    assert [(row[FOOD], row[PRESSURE]) for row in failed] == [("potato-large", 300.0)]
    said = grasp_campaign.counted(rows, "Fig. 6", 20, "20 of 20")
    assert "19 of 20 end in a class" in said
    asked = grasp_campaign.options("grasp_sweep", "").parse_args(["--out", str(out)])
    grasp_campaign.publish(rows, said, asked, grasp_sweep.TABLE, grasp_sweep.draw)
    assert (out / "grasp_sweep.png").stat().st_size > 1000
    with (out / "grasp_sweep.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert table[0]["angle_A_deg"] == "80"


def test_random_grasps_of_a_seed() -> None:
    """A longer table contains the shorter one; what cannot stand is drawn again."""

    def possible(inputs: dict[str, Any]) -> bool:
        return inputs[POSE] != "scoop"

    few, many = (random_grasps.draw(number, 3, possible) for number in (5, 12))
    assert many[:5] == few
    assert len({json.dumps(point) for point in many}) == 12
    for point in many:
        assert point[POSE] != "scoop"
        assert 100 <= float(point[PRESSURE]) <= 300
        assert 0.1 <= float(point[FRICTION]) <= 0.8


def test_a_grasp_runs_on_one_rank() -> None:
    with pytest.raises(configuration.ConfigError, match="--ranks 2: allowed: 1"):
        grasps.simulate({}, grasps.QUANTITIES, 2)

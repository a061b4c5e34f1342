"""Designs of a grasp, which has no gradient: a search by Gaussian processes.

Margins are invented, so that the best design is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from support.example import EXAMPLES

from dolfingrip.config import ConfigError
from dolfingrip.design.gradient import run, starts
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.read import read
from dolfingrip.design.gradient.starts import SearchPolicy
from dolfingrip.design.quantities import grasp
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.files.design import DesignFile

EXAMPLE = EXAMPLES / "gripper_design.toml"

TEXT = """
set = [
    "food.kind=cube", "gripper.preset=coarse", "gripper.alpha_deg=30", "gripper.clearance_mm=5",
]
[objective]
maximise = "pickup_margin"
[[constraints]]
of = "mass_g"
at_most = 40.0
[parameters]
morph.xi1 = [-0.2, 0.6]
gripper.alpha_deg = [0.0, 90.0]
[[scenarios]]
set = ["food.kind=sausage-short"]
[method]
simulations = 28
"""


def margins(requests: Sequence[Request]) -> list[Answer]:
    """The worse food's margin is largest, 1.0, at ξ1 = 0.2 and α = 45°; none above 80°."""
    found = []
    for request in requests:
        config = request.config
        assert request.experiment.name == "grasp"
        a, b = (config.morph.xi1 - 0.2) / 0.4, (config.gripper.alpha - 45) / 45
        if config.gripper.alpha > 80:
            found.append(Answer(failure_class="no class", failure="invented"))
            continue
        food = {"cube": 1.0 + a, "sausage-short": 1.0 - a}[config.food.kind]
        # fingers that press with the food's weight, and bear it so many times
        rows = {**dict.fromkeys(grasp.READ, 0.0), "normal_A_N": 1.0, "table_N": 1.0}
        rows |= {"normal_B_N": 0.0, "normal_C_N": 0.0, "table_z_mm": 0.0}
        rows |= {"contact_pressure_kPa": 0.0, "force_closure": food - b**2}
        columns = {name: np.array([value]) for name, value in rows.items()}
        outcome = {"kind": "picked up", "sentence": "invented", "time_s": 1.0}
        found.append(Answer(columns, outcome=outcome, wall_s=1.0))
    return found


def problem_of(folder: Path, text: str) -> Problem:
    file = folder / "design.toml"
    file.write_text(text, encoding="utf-8")
    return read(file)


@pytest.mark.slow
def test_the_worse_food_counts(tmp_path: Path) -> None:
    cheaper = SearchPolicy(candidates=128, near=64)
    problem = problem_of(tmp_path, TEXT)
    found = starts.solve(problem, margins, lambda trial, limits: None, cheaper).best(problem)
    assert found.simulations <= 28
    taken = [each.objective for each in found.trials if each.accepted]
    assert (np.diff(taken) > 0).all()
    assert found.best.objective == pytest.approx(1.0, abs=0.06)
    assert found.best.values == pytest.approx([0.2, 45.0], abs=12.0)
    told = run.facts(problem, found, None, 0.0)
    by = {each.condition: each.objective for each in told.by_condition}
    assert min(by.values()) == pytest.approx(found.best.objective)
    assert set(by) == {"nominal", "food.kind=sausage-short"}
    assert told.write(tmp_path).is_file()
    assert DesignFile.read(tmp_path) == told


def test_a_search_whose_designs_fail_does_not_tell_an_optimum(tmp_path: Path) -> None:
    """Those that fail count as bad while it looks on, and as not known where it ends."""
    problem = problem_of(tmp_path, TEXT.replace("simulations = 28", "simulations = 10"))
    seen: list[Request] = []

    def begun(requests: Sequence[Request]) -> list[Answer]:
        seen.extend(requests)
        fails = len(seen) > 2  # the start, of two foods
        found = [Answer(failure_class="contact", failure="invented")] * len(requests)
        return found if fails else margins(requests)

    cheaper = SearchPolicy(candidates=16, near=8)
    ending = starts.solve(problem, begun, lambda trial, limits: None, cheaper).best(problem).ending
    count = len(seen) - 1  # one food of each further design is tried
    assert ending.endswith(f"; not known of {count - 1} of {count} designs (contact: invented)")


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('of = "mass_g"', 'of = "force_N"\nat_pressure_kPa = 50.0', "allowed with a grasp"),
        ("simulations = 28", "starts = 3", "allowed with an objective that has a gradient"),
        ("alpha_deg = [0.0", "alpha_deg = [-95.0", "gripper.alpha_deg = -95"),
        ("gripper.alpha_deg = [0.0, 90.0]", "food.friction = [0.1, 0.5]", "food.friction"),
    ],
)
def test_bad_input_gets_one_line(tmp_path: Path, before: str, after: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        problem_of(tmp_path, TEXT.replace(before, after))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_example() -> None:
    """The four foods, and a finger with its pose."""
    problem = read(EXAMPLE)
    foods = {each.base.food.kind for each in problem.conditions}
    assert foods == {"sausage-short", "sausage-long", "potato-small", "potato-large"}
    assert {each.key.partition(".")[0] for each in problem.variables} == {"morph", "gripper"}

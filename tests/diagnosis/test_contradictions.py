"""No page contradicts itself: answers to many draws of a coupon's readings, in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.delivered import delivered
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis, diagnosed
from dolfingrip.diagnosis.answer.discrepancy import smooth_curves
from dolfingrip.diagnosis.answer.errors import without_memory
from dolfingrip.diagnosis.answer.settling import settled_by
from dolfingrip.diagnosis.core.decision import Decision, decide
from dolfingrip.diagnosis.core.search import search
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.files.diagnosis_words import LONGEST, lines

SEED = 3
MODULUS = "material.mu_MPa"
EFFECTS = ("mooney_rivlin", "prony", "permanent_set", "force_gain")
TRAVELS_mm = np.linspace(0.0, 16.5, 12)
TOLD = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.05
"""
STRENGTHS = (0.03, 0.3)


@pytest.fixture(scope="module")
def pulled(tmp_path_factory: pytest.TempPathFactory) -> Analysis[Any]:
    """A coupon that is pulled once."""
    return analysed(tmp_path_factory.mktemp("coupon"), TRAVELS_mm, EFFECTS)


def analysed(folder: Path, travels_mm: np.ndarray, effects: Sequence[str]) -> Analysis[Any]:
    """A coupon that is pulled at 0.5 mm/s, read at travels, (n,)."""
    times_s = np.cumsum(np.abs(np.diff(travels_mm, prepend=0.0))) / 0.5
    rows = "\n".join(f"{t},{u},{u}" for t, u in zip(times_s, travels_mm, strict=True))
    csv = f"time_s,displacement_mm,force_N\n{rows}\n"
    measurement, config = read([written(folder, csv, TOLD)], Config()), Config()
    causes = unknowns(measurement, config, effects)
    return analyse(CouponSimulation(measurement, config), causes)


def answered(pulled: Analysis[Any], change: np.ndarray, rng: np.random.Generator) -> Diagnosis:
    """The answer to readings that a change was made to, with noise."""
    value = pulled.problem.base + change + pulled.errors.noise * rng.standard_normal(len(change))
    own = replace(pulled, problem=replace(pulled.problem, value=value))
    found = diagnosed(own, Config(), quick=True)
    found.next, _ = settled_by(found, lambda text: None, simulating=False)
    return found


def contradictions(found: Diagnosis, result: DiagnosisFile) -> list[str]:
    """Pairs of fields of a page of which only one can be true."""
    decision, verdict, said = found.decision, result.verdict, []
    content = result.advice is not None and result.advice.way in ("nothing", "finger")
    may_act = {each.name for each in result.causes if each.open}
    if not verdict.claimed and result.advice is not None and result.advice.way == "nothing":
        said.append("the verdict is in doubt, the advice is content")
    if content and may_act and decision.answer != "cause":
        said.append("causes may act, the advice is content")
    if may_act != {*found.open_names}:
        said.append("causes that are open are not all told")
    if {*result.hides} & {*verdict.effects, *verdict.second}:
        said.append("the verdict names what is hidden")
    if decision.answer == "none" and decision.best is not found.none:
        said.append("nothing but noise is told, and numbers of a fit with more")
    if decision.answer == "none" and verdict.probability > result.none + 1e-9:
        said.append("that nothing acts is surer than that nothing is seen")
    if verdict.least > verdict.probability:
        said.append("the worst prior is surer than the best")
    told = {each for test in result.next_experiments for part in test.tells
            for each in part.split(" with ")}  # fmt: skip
    if told - {each.name for each in result.causes}:
        said.append("a test tells of a cause that the page has nowhere else")
    if result.advice is None and not told.issuperset(found.tied):
        said.append("causes are open that no test tells, and there is no advice")
    listed = {each.key: each for each in result.fits[0].parameters}
    doubtful = not verdict.claimed and decision.answer != "cause"
    for name in (n for n, p in decision.inclusion.items() if doubtful and p > 0.1):
        for each in found.numbers(found.member(name)):
            held = listed.get(each.key, each)
            if held.low > each.low or held.high < each.high:
                said.append(f"{name} may act, whose {each.key} the numbers exclude")
    named = {*decision.first, *decision.second, *decision.nearest}
    likely = {name for name, p in decision.inclusion.items() if p > Policy().claimed}
    if decision.answer == "none" and likely - named - {*found.analysis.problem.implausible}:
        said.append("none is the answer beside a probable cause")
    if any(len(line.split()) > LONGEST for line in lines(result)):
        said.append("a line is too long")
    return said


@pytest.mark.slow
def test_no_page_contradicts_itself(pulled: Analysis[Any], tmp_path: Path) -> None:
    """Nothing hidden, each effect at two strengths, and a jump that no effect is."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    problem = pulled.problem
    at_rest = np.zeros(problem.nuisance_count)
    changes = {"none": np.zeros(len(problem.value))}
    for name in (each for each in EFFECTS if each in pulled.causes):
        for strength in STRENGTHS:
            zeta = pulled.causes[name].at_strength(strength)
            changes[f"{name} {strength}"] = problem.change(name, at_rest, zeta)
    load = TRAVELS_mm[-len(problem.value) :]
    changes |= {f"jump {by}": by * (load > 10.0) for by in (0.1, 2.0)}
    answers = set()
    for name, change in changes.items():
        found = answered(pulled, change, rng)
        result = delivered(found, tmp_path).result
        print(name, found.decision.answer, round(found.probability, 3), *lines(result))
        answers.add((found.decision.answer, found.claimed))
        assert contradictions(found, result) == [], (name, result)
    assert {("none", False), ("cause", True), ("cause", False), ("unknown", False)} <= answers


@pytest.mark.slow
def test_intervals_hold_whatever_hides(pulled: Analysis[Any]) -> None:
    """A load cell that reads 1.5 % too much hides behind the modulus, told 1.5 % too stiff."""
    problem = pulled.problem
    print("seed", SEED)
    found = answered(pulled, 0.015 * problem.base, np.random.default_rng(SEED))
    assert found.decision.answer == "none"
    assert not found.claimed
    assert "force_gain" in found.open_names
    (told,) = (each for each in found.numbers(found.decision.best) if each.key == MODULUS)
    print(told)
    assert told.low < 2.93 < told.high
    # reference: the load cell's prior is as wide as what it hides
    assert (told.high - told.low) / 2.93 > 2 * 1.645 * 0.01


@pytest.mark.slow
def test_memory_from_one_rate_has_an_elastic_rival(pulled: Analysis[Any], tmp_path: Path) -> None:
    """Viscosity that one pull shows strongly is named at no more than even odds; a coupon that is
    pulled up and down names it alone (``plan/test_naming.py``)."""
    problem = pulled.problem
    at_rest = np.zeros(problem.nuisance_count)
    zeta = pulled.causes["prony"].at_strength()
    alone = replace(pulled, problem=replace(
        problem, numbers={"prony": problem.numbers["prony"]},
        always=(problem.factor, *(replace(each, names=()) for each in problem.always[1:])),
    ))  # fmt: skip
    found = answered(alone, 2 * problem.change("prony", at_rest, zeta), np.random.default_rng(SEED))
    assert found.decision.first == ("prony",)
    assert found.decision.by_shape
    assert found.probability <= 0.5
    result = delivered(found, tmp_path).result
    assert result.verdict.by_shape
    assert not result.verdict.claimed
    assert not contradictions(found, result)


def test_friction_in_the_rig_has_the_shape_of_memory(tmp_path: Path) -> None:
    """One pull whose guides rub, with a force that rises within 0.8 mm and stays: no smooth elastic
    curve has that shape. Reference: χ², which noise alone leaves below the number of readings."""
    own = analysed(tmp_path, np.linspace(0.0, 16.5, 100), ["permanent_set"])
    errors, travel_mm = own.errors, own.measurement.listed["control"].to_numpy()
    off = -0.8 * np.expm1(-travel_mm / 0.8)
    smooth, every = smooth_curves(errors.along), without_memory(own.measurement, errors)

    def left(curves: np.ndarray) -> float:
        total = np.diag(np.full(len(off), 0.01**2)) + curves @ curves.T
        return float(off @ np.linalg.solve(total, off))

    print(left(smooth), left(every))
    assert left(smooth) > 30
    assert left(every) < 10


def test_a_loop_of_friction_is_not_claimed_as_one_of_the_material(tmp_path: Path) -> None:
    """Guides that rub either way, beside a network that yields, both pulled up and down; no
    artefact is looked for. Reference: the changes are what they are called."""
    way = np.r_[np.linspace(0.0, 16.5, 30), np.linspace(16.5, 0.0, 30)[1:]]
    own = analysed(tmp_path, way, ["permanent_set"]).judged_by_shape()
    problem, behind, rubs = own.problem, 0.0, []
    for step in np.diff(own.measurement.listed["control"], prepend=0.0):
        behind = np.sign(step) + (behind - np.sign(step)) * np.exp(-abs(step) / 0.8)
        rubs.append(0.6 * behind)
    at_rest = np.zeros(problem.nuisance_count)
    zeta = own.causes["permanent_set"].at_strength()
    noise = own.errors.noise * np.random.default_rng(SEED).standard_normal(len(rubs))

    def decided(change: np.ndarray, curves: np.ndarray | None) -> Decision:
        read = replace(problem, value=problem.base + change + noise, curves=curves)
        return decide(search(read, np.random.default_rng(SEED)))

    yields = decided(problem.change("permanent_set", at_rest, zeta), problem.curves)
    assert (yields.first, yields.by_shape) == (("permanent_set",), False)
    assert yields.probability > 0.9
    claimed = decided(np.array(rubs), None)
    assert (claimed.first, claimed.by_shape) == (("permanent_set",), False)
    assert claimed.probability > Policy().claimed
    rubbed = decided(np.array(rubs), problem.curves)
    assert (rubbed.answer, rubbed.by_shape) == ("cause", True)
    assert rubbed.probability <= 0.5

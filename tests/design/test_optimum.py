"""Choices along a front, what is computed again, and what the surrogate is said to have missed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from support import stand_in

from dolfingrip.design.optimum import files, optimum, resolve
from dolfingrip.design.optimum.genetic import Settings
from dolfingrip.design.optimum.optimum import Optimum
from dolfingrip.design.optimum.resolve import FailedSolve, Outputs, Resolved, SelectedDesign
from dolfingrip.design.surrogate.training import Training
from dolfingrip.files.optimum import OptimumFile

SMALL = Settings(population=60, generations=20)


@pytest.fixture(scope="module")
def found(training: Training) -> Optimum:
    return optimum.find(training.surrogate, [2.5, 3.0, 0.1], SMALL)


def _truth(designs: Sequence[dict[str, float]]) -> list[Outputs | FailedSolve]:
    values = stand_in.outputs(np.array([list(design.values()) for design in designs]))
    return [{"cog_offset_mm": float(cog), "force_N": float(force)} for cog, force in values]


def test_choices_then_the_original_then_the_front(found: Optimum) -> None:
    roles = [one.role for one in found.candidates]
    assert roles[:2] == ["chosen", "chosen"]
    assert roles.index("original") == 2
    assert roles.count("front") == 10
    assert found.missed == [0.1]  # the front begins at 0.3 mm
    chosen = found.candidates[1]
    assert chosen.cog_max_mm == 3.0
    assert chosen.predicted["cog_offset_mm"] <= 3.0
    along = [one.predicted["cog_offset_mm"] for one in found.candidates if one.role == "front"]
    assert along == sorted(along)
    assert along[0] == pytest.approx(found.front.cog_mm[0])
    assert along[-1] == pytest.approx(found.front.cog_mm[-1])


def test_each_design_is_computed_once(found: Optimum) -> None:
    asked: list[dict[str, float]] = []

    def evaluate(designs: Sequence[dict[str, float]]) -> list[Outputs | FailedSolve]:
        asked.extend(designs)
        return _truth(designs)

    twice = [*found.candidates, found.candidates[0]]
    resolved = resolve.resolve(twice, evaluate)
    assert len(resolved) == len(twice)
    assert len({tuple(design.items()) for design in asked}) == len(asked)
    for one in resolved:
        assert isinstance(one.computed, dict)
        assert one.computed == pytest.approx(_truth([one.candidate.inputs])[0])


def test_error_is_that_of_the_surrogate_on_the_front(found: Optimum) -> None:
    resolved = optimum.compute(found, _truth)
    error = resolve.errors(resolved)["force_N"]
    along = [one for one in resolved if one.candidate.role == "front"]
    miss = np.array([one.candidate.predicted["force_N"] for one in along]) - np.array(
        [_truth([one.candidate.inputs])[0]["force_N"] for one in along]
    )
    assert error["designs"] == 10
    assert error["rms"] == pytest.approx(np.sqrt(np.mean(miss**2)))
    assert error["largest"] == pytest.approx(np.abs(miss).max())
    assert error["relative"] < 0.02


def test_failed_designs_are_told_and_never_numbers(found: Optimum, tmp_path: Path) -> None:
    def evaluate(designs: Sequence[dict[str, float]]) -> list[Outputs | FailedSolve]:
        known = _truth(designs)
        return [FailedSolve("stopped at 12 kPa"), *known[1:-1], FailedSolve("no mesh")]

    resolved = optimum.compute(found, evaluate)
    assert math.isnan(resolved[0].miss("force_N"))
    assert resolve.errors(resolved)["force_N"]["designs"] == 9
    facts = files.write(found, resolved, tmp_path)
    assert facts.designs[0].fem is None
    assert facts.designs[0].failure == "stopped at 12 kPa"
    assert OptimumFile.read(tmp_path) == facts
    lines = (tmp_path / "resolved.csv").read_text(encoding="utf-8").splitlines()
    assert lines[1].endswith(",,failed,stopped at 12 kPa")
    assert "nan" not in "".join(lines).lower()
    nothing = [Resolved(one.candidate, FailedSolve("lost")) for one in resolved]
    assert resolve.errors(nothing) == {}


def test_gain_is_over_the_original_as_computed(found: Optimum) -> None:
    resolved = optimum.compute(found, _truth)
    chosen = resolved[1]
    expected = _truth([chosen.candidate.inputs])[0]["force_N"] / stand_in.FORCE_N - 1
    assert resolve.improvement(resolved, chosen) == pytest.approx(expected)
    assert resolve.improvement(resolved[:2], chosen) is None  # no original among them


def test_the_original_is_none_of_a_space_without_it(training: Training) -> None:
    (one,) = resolve.original(training.surrogate)
    assert one == SelectedDesign(
        "original", None, {"morph.xi1": 0.0, "morph.xi2": 0.0}, one.predicted
    )

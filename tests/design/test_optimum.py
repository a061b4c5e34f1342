"""Choices along a front, what is computed again, and what the surrogate is said to have missed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from support import stand_in

from dolfingrip.design.optimum import optimum
from dolfingrip.design.optimum.optimum import Recomputed
from dolfingrip.design.optimum.pareto import NSGA2Settings
from dolfingrip.design.surrogate.training import Training
from dolfingrip.files.optimum import OptimumFile

SMALL = NSGA2Settings(population=60, generations=20)


@pytest.fixture(scope="module")
def found(training: Training) -> OptimumFile:
    return optimum.find(training.surrogate, stand_in.OBJECTIVES, [2.5, 3.0, 0.1], SMALL)


def _truth(designs: Sequence[dict[str, float]]) -> list[Recomputed]:
    values = stand_in.outputs(np.array([list(design.values()) for design in designs]))
    return [
        Recomputed({"cog_offset_mm": float(cog), "force_N": float(force)}) for cog, force in values
    ]


def _true(inputs: dict[str, float]) -> dict[str, float]:
    (found,) = _truth([inputs])
    assert found.fem is not None
    return found.fem


def test_choices_then_the_original_then_the_front(found: OptimumFile) -> None:
    roles = [one.role for one in found.designs]
    assert roles[:2] == ["chosen", "chosen"]
    assert roles.index("original") == 2
    assert found.limits_below_the_front == (0.1,)  # the front begins at 0.3 mm
    chosen = found.designs[1]
    assert chosen.limit == 3.0
    assert chosen.surrogate["cog_offset_mm"] <= 3.0
    again = optimum.resolve(found, 10, _truth)
    assert [one.fem is not None for one in again.front].count(True) == 10
    along = [one.surrogate["cog_offset_mm"] for one in again.front if one.fem is not None]
    assert along == sorted(along)
    assert along[0] == found.front[0].surrogate["cog_offset_mm"]
    assert along[-1] == found.front[-1].surrogate["cog_offset_mm"]


def test_each_design_is_computed_once(found: OptimumFile) -> None:
    asked: list[dict[str, float]] = []

    def evaluate(designs: Sequence[dict[str, float]]) -> list[Recomputed]:
        asked.extend(designs)
        return _truth(designs)

    twice = found.model_copy(update={"designs": (*found.designs, found.designs[0])})
    again = optimum.resolve(twice, 10, evaluate)
    assert len(again.designs) == len(twice.designs)
    assert len({tuple(design.items()) for design in asked}) == len(asked)
    for one in again.designs:
        assert one.fem == pytest.approx(_true(one.inputs))
        assert one.resolved
    for point in again.front:
        assert point.fem is None or point.fem == pytest.approx(_true(point.inputs))


def test_error_is_that_of_the_surrogate_on_the_front(found: OptimumFile) -> None:
    again = optimum.resolve(found, 10, _truth)
    error = again.surrogate_error_on_front["force_N"]
    along = [one for one in again.front if one.fem is not None]
    miss = np.array([one.surrogate["force_N"] - _true(one.inputs)["force_N"] for one in along])
    assert error.designs == 10
    assert error.rms == pytest.approx(np.sqrt(np.mean(miss**2)))
    assert error.largest == pytest.approx(np.abs(miss).max())
    assert error.relative < 0.02


def test_failed_designs_are_told_and_never_numbers(found: OptimumFile, tmp_path: Path) -> None:
    def evaluate(designs: Sequence[dict[str, float]]) -> list[Recomputed]:
        known = _truth(designs)
        lost = Recomputed(None, "stopped at 12 kPa"), Recomputed(None, "no mesh")
        return [lost[0], *known[1:-1], lost[1]]

    again = optimum.resolve(found, 10, evaluate)
    assert again.surrogate_error_on_front["force_N"].designs == 9
    optimum.write(again, tmp_path)
    assert again.designs[0].fem is None
    assert again.designs[0].failure == "stopped at 12 kPa"
    assert OptimumFile.read(tmp_path) == again
    lines = (tmp_path / "resolved.csv").read_text(encoding="utf-8").splitlines()
    assert lines[1].endswith(",,failed,stopped at 12 kPa")
    assert lines[-1].endswith(",,failed,no mesh")
    assert "nan" not in "".join(lines).lower()
    nothing = optimum.resolve(found, 10, lambda designs: [Recomputed(None, "lost")] * len(designs))
    assert nothing.surrogate_error_on_front == {}


def test_gain_is_over_the_original_as_computed(found: OptimumFile) -> None:
    chosen = optimum.resolve(found, 10, _truth).designs[1]
    expected = _true(chosen.inputs)["force_N"] / stand_in.FORCE_N - 1
    assert chosen.gain == pytest.approx(expected)
    alone = found.model_copy(update={"designs": found.designs[:2]})
    assert optimum.resolve(alone, 0, _truth).designs[1].gain is None  # no original among them


def test_the_original_is_in_the_surrogate_s_range(found: OptimumFile) -> None:
    (one,) = [each for each in found.designs if each.role == "original"]
    assert one.inputs == {"morph.xi1": 0.0, "morph.xi2": 0.0}
    assert one.limit is None

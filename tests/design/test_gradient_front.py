"""Fronts by a process that learns from values and gradients."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.invented import FORCE, TWO, Invented, written

from dolfingrip.design.gradient.front import FrontFinder
from dolfingrip.design.gradient.read import read
from dolfingrip.design.gradient.shape import UnloadedShapes
from dolfingrip.design.surrogate.process import GradientProcess


def test_a_process_learns_from_gradients() -> None:
    """Of a smooth function, from seven places with gradients, better than from values alone."""
    rng = np.random.default_rng(5)
    at, there = rng.random((7, 2)), rng.random((200, 2))

    def function(x: np.ndarray) -> np.ndarray:
        return np.asarray(np.sin(3 * x[:, 0]) + x[:, 0] * x[:, 1] ** 2)

    slopes = np.stack([3 * np.cos(3 * at[:, 0]) + at[:, 1] ** 2, 2 * at[:, 0] * at[:, 1]], axis=1)
    process = GradientProcess(at, function(at), slopes)
    mean, deviation = process.predict(at)
    np.testing.assert_allclose(mean, function(at), atol=1e-3)
    assert deviation.max() < 1e-2
    off, rough = (
        np.abs(each.predict(there)[0] - function(there)).max()
        for each in (process, GradientProcess(at, function(at)))
    )
    print("largest errors with and without gradients", off, rough)
    assert off < 0.1
    assert off < rough / 2
    inside = np.abs(mean - function(at)) <= 3 * deviation + 1e-3
    assert inside.all()


def test_a_front_of_few_simulations(tmp_path: Path) -> None:
    """It is the best of a fine grid for each COG offset, to a hundredth of its range."""
    front = '[front]\nagainst = "cog_offset_mm"\nlow = 0.0\nhigh = 5.0\n'
    problem = read(written(tmp_path, FORCE + TWO + front))
    assert problem.front is not None
    answer = Invented(lambda config: config.morph.xi1 > 0.9)
    found = FrontFinder(problem, problem.front, answer).run()
    assert len(answer.asked) <= 20
    assert found.unsure[-1] < problem.front.unsure
    shapes = UnloadedShapes(problem)
    span = np.ptp([each.mean for each in found.levels])
    for level in found.levels[::8]:
        shape = shapes.at([value for value, _, _ in level.inputs.values()])
        assert shape.value("cog_offset_mm") <= level.limit + 1e-9
        assert Invented.force_N(shape.config) == pytest.approx(level.mean, abs=0.01 * span)

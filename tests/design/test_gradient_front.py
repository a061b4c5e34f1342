"""Fronts by a process that learns from values and gradients."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from support.invented import FORCE, TWO, Invented, written

from dolfingrip.config import ConfigError
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


FORCE_BY_ANGLE = f"""{FORCE}
[front]
against = "angle_deg"
at_pressure_kPa = 50.0
low = 5.0
high = 28.0
unsure = 0.02
"""
MASS_BY_FORCE = """
[objective]
minimise = "mass_g"

[front]
against = "force_N"
at_pressure_kPa = 50.0
sense = "at least"
low = 1.0
high = 2.8
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "limited"), [(FORCE_BY_ANGLE, "angle_deg"), (MASS_BY_FORCE, "force_N")]
)
def test_a_front_against_a_reading(tmp_path: Path, text: str, limited: str) -> None:
    """It is no worse than a fine grid by 5 % of its range, and its designs keep limits to 2 %.

    A reading is known at the simulated designs alone, the mass everywhere. Candidates lie 1/44 of
    a parameter's range apart, which costs up to 4 % of the force next to a limit.
    """
    narrow = TWO.replace("[-0.2, 1.0]", "[-0.2, 0.8]").replace("[-0.5, 1.0]", "[-0.4, 0.4]")
    problem = read(written(tmp_path, text + narrow))
    asked = problem.front
    assert asked is not None
    found = FrontFinder(problem, asked, Invented()).run()
    first, second = found.objectives
    assert (first.title, first.sense) == (f"{limited} at 50 kPa", asked.sense)
    assert found.unsure[-1] < asked.unsure
    limits, means = np.array([(each.limit, each.mean) for each in found.levels]).T
    assert asked.low <= limits.min() < limits.max() <= asked.high
    shapes = UnloadedShapes(problem)

    def numbers(values: Sequence[float]) -> tuple[float, float]:
        """Both quantities of a design, signed."""
        shape = shapes.at(values)
        known = getattr(Invented, second.name, None)
        improved = shape.value(second.name) if known is None else known(shape.config)
        return first.sign * getattr(Invented, limited)(shape.config), second.sign * improved

    axes = np.linspace(-0.2, 0.8, 21), np.linspace(-0.4, 0.4, 17)
    at, best = np.array([numbers(each) for each in product(*axes)]).T
    for limit, mean in zip(first.sign * limits[4::8], second.sign * means[4::8], strict=True):
        assert mean <= best[at <= limit].min() + 0.05 * np.ptp(means)
    for level in found.levels[::8]:
        own, _ = numbers([value for value, _, _ in level.inputs.values()])
        assert own <= first.sign * level.limit + 0.02 * np.ptp(limits)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('against = "force_N"', "front.against = force_N: 0 places"),
        ('against = "wall"', "front.against = wall: allowed: "),
        ('against = "contact_gap_mm"', "front.against = contact_gap_mm: no gradient"),
        ('against = "force_N"\nat_pressure_kPa = 50.0', "allowed: another one than the objective"),
        ('against = "angle_deg"\nat_pressure_kPa = 50.0\nsense = "above"', "front.sense"),
    ],
)
def test_a_front_is_against_a_quantity_with_a_gradient(
    tmp_path: Path, text: str, said: str
) -> None:
    with pytest.raises(ConfigError, match=re.escape(said)) as error:
        read(written(tmp_path, f"{FORCE}{TWO}[front]\n{text}\nlow = 0.0\nhigh = 5.0\n"))
    assert "\n" not in str(error.value)


def test_a_limit_that_no_design_reaches(tmp_path: Path) -> None:
    """Of designs that fail it is not known; their angles are 40 − 30 ξ − 20 ξ² of ξ above 0.5."""
    front = '[front]\nagainst = "angle_deg"\nat_pressure_kPa = 50.0\nlow = 90.0\nhigh = 95.0\n'
    problem = read(written(tmp_path, FORCE + TWO + front))
    assert problem.front is not None
    with pytest.raises(ConfigError, match=r"angle_deg at 50 kPa is .* allowed: low and high among"):
        FrontFinder(problem, problem.front, Invented()).run()
    found = FrontFinder(problem, problem.front, Invented(lambda config: config.morph.xi1 > 0.5))
    known = r"ranges, not known of (\d+) designs \(limit point: invented\); allowed: low and high"
    with pytest.raises(ConfigError, match=known):
        found.run()


def test_a_front_of_failures_tells_why(tmp_path: Path) -> None:
    front = '[front]\nagainst = "angle_deg"\nat_pressure_kPa = 50.0\nlow = 10.0\nhigh = 20.0\n'
    problem = read(written(tmp_path, FORCE + TWO + front))
    assert problem.front is not None
    finder = FrontFinder(problem, problem.front, Invented(lambda config: True))
    with pytest.raises(ConfigError, match=r"no two designs .*: limit point: invented$"):
        finder.run()

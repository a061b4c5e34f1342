"""The numbers that a diagnosis decides by: few, in one place, and handed on as an argument."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

from support.checkout import needs_checkout
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import diagnosed
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse
from dolfingrip.diagnosis.simulation.unknowns import unknowns

ROOM = Path(__file__).resolve().parents[2] / "dolfingrip" / "diagnosis"
UNITS = {60.0: "seconds", 180.0: "degrees", 9.81: "m/s²", 6.895: "kPa"}
"""Factors of units: of a minute, of π, of a kilogram's weight, of a psi."""


def plain(number: float) -> bool:
    """Tell if a number decides nothing: 0, 1, 2, a half of a half, a power of ten, a unit."""
    size = abs(number)
    if size in {0, 2, *UNITS}:
        return True
    tens, halves = math.log10(size), -math.log2(size)
    return math.isclose(tens, round(tens), abs_tol=1e-12) or (halves >= 0 and halves.is_integer())


def numbers(text: str) -> Iterator[tuple[int, float]]:
    """Lines and numbers of code that are not plain."""
    for node in ast.walk(ast.parse(text)):
        if (
            isinstance(node, ast.Constant)
            and type(node.value) in {int, float}
            and not plain(float(node.value))
        ):
            yield node.lineno, node.value


@needs_checkout
def test_no_other_number_decides() -> None:
    for file in sorted(ROOM.rglob("*.py")):
        told = [*numbers(file.read_text(encoding="utf-8"))] if file.name != "policy.py" else []
        assert not told, f"{file.relative_to(ROOM)}: {told}"


def test_numbers_are_noticed() -> None:
    """Reference: by hand."""
    assert [*numbers("x = 3\ny = 0.9 * 10")] == [(1, 3), (2, 0.9)]
    assert not [*numbers("x = 0, 1, 2, 0.5, 0.125, 100, 1e-9, 60, -1")]


def test_there_are_few_and_a_measurement_hands_them_on(tmp_path: Path) -> None:
    """Reference: 60, as the answer to the same readings differs where a number does."""
    assert len(fields(Policy)) <= 60
    rows = "\n".join(f"{t},{t / 2},{2.0 * t / 34}" for t in range(0, 34, 2))
    told = (
        'experiment = "coupon"\ngauge_length_mm = 33.0\narea_mm2 = 9.0\n[noise]\nforce_N = 0.05\n'
    )
    file = written(tmp_path, f"time_s,displacement_mm,force_N\n{rows}\n", told)
    found = []
    for policy in (Policy(), Policy(prior_by_size=(0.5, 0.4, 0.1)), Policy(nearly=0.5)):
        measurement = read([file], Config(), policy)
        causes = unknowns(measurement, Config(), ["yeoh", "force_gain"])
        analysis = analyse(CouponSimulation(measurement, Config()), causes)
        answer = diagnosed(analysis, Config(), quick=True)
        assert answer.policy is policy
        modulus, *_ = answer.numbers(answer.none)
        found.append((answer.decision.none, modulus.high - modulus.low))
    print(found)
    (none, wide), (other_none, _), (_, narrow) = found
    assert none != other_none
    # of a normal distribution the ratio is 0.674 / 1.645
    assert narrow < 0.6 * wide

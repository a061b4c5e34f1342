"""A few of the random legal fingers of ``benchmarks/legal_fingers.py``, each on one rank."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import legal_fingers
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.sections.geometry.index import NAMES

SEED = 0


@pytest.mark.parametrize("number", [1, 2, 5])
def test_a_random_finger(number: int, tmp_path: Path) -> None:
    """It comes to its end or fails by a class, and no element is inverted."""
    print("seed", SEED)
    experiment, config = legal_fingers.drawn(number, SEED, tmp_path)
    assert config.finger.kind == NAMES[number % len(NAMES)]
    answer = compute(replace(Request.of(experiment, config), fields=tmp_path))
    assert answer.failure_class in (None, "limit point", "contact")
    assert legal_fingers.least_det_F(tmp_path) > 0
    assert len(answer.columns["pressure_kPa"]) > 1


def test_a_draw_is_repeatable(tmp_path: Path) -> None:
    first, again, other = (
        legal_fingers.drawn(number, seed, tmp_path) for number, seed in ((6, 3), (6, 3), (6, 4))
    )
    assert first == again
    assert first != other


def test_how_far_answers_are_apart() -> None:
    def answer(*angles: float) -> Answer:
        return Answer({"angle_deg": np.array(angles), "iterations": np.array(angles)})

    one = answer(0.0, 50.0)
    assert legal_fingers.apart([one, one]) == 0
    assert legal_fingers.apart([one, one, answer(5e-7, 50.0)]) == pytest.approx(1e-8)
    assert legal_fingers.apart([one, answer(0.0)]) == float("inf")
    assert legal_fingers.apart([one, Answer()]) == float("inf")

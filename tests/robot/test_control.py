"""Laws of joints as a simulator's loop takes them, by values worked out by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.robot.control import BLUE, PALE, RED, JointLaws


@pytest.fixture
def laws(tmp_path: Path) -> JointLaws:
    joints = [
        {"coordinates": [{"name": "bend", "kind": "hinge", "law": [2.0, 0.5, -60.0, 1e-3]}]},
        {"coordinates": [{"name": "stretch", "kind": "slide", "law": [0.3, -0.01, -4.0, 2e-4]}]},
    ]
    file = tmp_path / "robot.json"
    file.write_text(json.dumps({"joints": joints, "valid": {"pressure_kPa": [0.0, 200.0]}}))
    return JointLaws(file)


def test_efforts_are_in_newton_metres_and_newtons(laws: JointLaws) -> None:
    """Of a hinge (a p + b p w + c w + d p²) N·mm; of a slide w is in mm, and its place in m."""
    assert laws.names == ["bend", "stretch"]
    p, turn, pull_mm = 100.0, 0.2, 1.5
    expected = [
        1e-3 * (2.0 * p + 0.5 * p * turn - 60.0 * turn + 1e-3 * p**2),
        0.3 * p - 0.01 * p * pull_mm - 4.0 * pull_mm + 2e-4 * p**2,
    ]
    efforts = laws.efforts(p, np.array([turn, 1e-3 * pull_mm]))
    np.testing.assert_allclose(efforts, expected, rtol=1e-12)
    assert not laws.efforts(0.0, np.zeros(2)).any()


def test_colours_end_at_the_highest_pressure_and_at_as_much_suction(laws: JointLaws) -> None:
    for pressure, colour in ((0.0, PALE), (200.0, RED), (500.0, RED), (-200.0, BLUE)):
        np.testing.assert_allclose(laws.colour(pressure), colour)
    np.testing.assert_allclose(laws.colour(100.0), (PALE + RED) / 2)

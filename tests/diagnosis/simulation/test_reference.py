"""Changes that are written and read again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import reference
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.simulation.simulated import Case, Simulated


def cubic(measurement: Measurement) -> np.ndarray:
    """An invented change that splines meet."""
    led = measurement.listed()["led"].to_numpy() / 250
    return led + led**3


def test_changes_come_back_at_other_pressures(tmp_path: Path) -> None:
    paper = reference.paper_measurement()
    assert len(paper.listed()) == 11 * (4 + 5)
    shapes = np.array([cubic(paper), -2 * cubic(paper)])
    made = Candidate(
        "ogden", "elastic", shapes, ("a", "b"), (("x=1",), ("x=2",)), (1.0, 0.5), 1.1, False,
        "ungraded",
    )  # fmt: skip
    zeros = np.zeros(len(paper.listed()))
    nothing = Simulated(Case(), zeros, zeros)
    base = BaseSimulation(paper, Config(), nothing, (), zeros[:, None], [made])
    reference.write(base, tmp_path / "reference.json")
    known = reference.read(tmp_path / "reference.json")
    other = reference.paper_measurement((0.0, 40.0, 111.0, 250.0))
    (found,) = known.at(other)
    expected = np.array([cubic(other), -2 * cubic(other)])
    np.testing.assert_allclose(found.shapes, expected, atol=1e-4)
    assert (found.overrides, found.parts, found.one_sided) == (made.overrides, made.parts, False)
    other.readings["branch"] = "unloading"
    with pytest.raises(ConfigError, match="allowed: first loadings in bending, blocked_force"):
        known.at(other)

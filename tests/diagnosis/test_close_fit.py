"""A fit that begins on the graded mesh, as a surface is close to what a simulation gives there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from diagnosis import hidden_bending
from diagnosis.simulation.here import Here

from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, diagnose_measurement
from dolfingrip.diagnosis.fit import STRAIGHT
from dolfingrip.diagnosis.step import visit

WAY = (0, 20, 40, 60, 40, 20, 0)
G, TAU_s = 0.28, 4.0
"""Between the values that the screen tries: g = 0.2, τ = 2, 13 and 90 s."""
SEED = 12


def test_one_simulation_on_the_graded_mesh_finds_a_viscosity(tmp_path: Path) -> None:
    config = hidden_bending.config()
    hidden = {"prony": {"g": [G], "tau_s": [TAU_s]}}
    file = hidden_bending.measured(tmp_path, hidden, WAY, SEED)
    settings = Settings(effects=("prony",))
    found = diagnose_measurement(read([file], config), config, Here(tmp_path / "store"), settings)
    fit = found.fits[frozenset(["prony"])]
    estimates = dict(zip(fit.by_key, fit.estimates(found.problem), strict=True))
    print(estimates, "evaluations", fit.evaluations)
    assert fit.evaluations == 1
    for key, hidden_value in (("g", G), ("tau_s", TAU_s)):
        told = estimates[f"extensions.prony.{key}"]
        wide = told.high - told.low
        assert told.low - 0.5 * wide < hidden_value < told.high + 0.5 * wide

    # Reference: a simulation where the step along the tangent ended.
    assert fit.model is not None
    there = visit(found.problem, fit.model.evaluate, fit.model, fit.zeta)
    off = found.problem.covariance.whiten(there.readings - fit.readings)
    print("off the tangent by", np.linalg.norm(off))
    assert np.linalg.norm(off) < 2 * STRAIGHT

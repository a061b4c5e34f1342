"""A fit on a short finger: sought on the ungraded mesh, ended on the graded one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from diagnosis import hidden_bending
from diagnosis.simulation.here import Here

from dolfingrip.diagnosis.cautions import MESH_UNKNOWN
from dolfingrip.diagnosis.conclude import NONE
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, diagnose_measurement
from dolfingrip.diagnosis.simulation import meshes

PRESSURES_kPa = (0, 25, 50, 75, 100)
HIDDEN_MPa = 1.8
SEED = 5


def test_hidden_softening_is_found_at_its_strength(tmp_path: Path) -> None:
    """The truth was simulated on the graded mesh; the ungraded one alone would be off by more."""
    config = hidden_bending.config()
    hidden = {"mooney_rivlin": {"C01_MPa": HIDDEN_MPa}}
    file = hidden_bending.measured(tmp_path, hidden, PRESSURES_kPa, SEED)
    settings = Settings(effects=("mooney_rivlin",))
    found = diagnose_measurement(read([file], config), config, Here(tmp_path / "store"), settings)
    assert meshes.ungraded(config)
    assert found.problem.errors.shape[1] == 1
    assert MESH_UNKNOWN not in found.warnings
    fit = found.fits[frozenset(["mooney_rivlin"])]
    (_, strength) = fit.estimates(found.problem)
    print("C01", strength, "log evidence", fit.log_evidence(found.problem),
          "none", found.fits[NONE].log_evidence(found.problem))  # fmt: skip
    wide = strength.high - strength.low
    assert strength.low - 0.5 * wide < HIDDEN_MPa < strength.high + 0.5 * wide
    assert wide < HIDDEN_MPa
    left = found.problem.value - fit.predicted(found.problem, np.ones(len(PRESSURES_kPa) * 2, bool))
    assert np.abs(left / found.problem.noise_std).max() == pytest.approx(0, abs=3.5)

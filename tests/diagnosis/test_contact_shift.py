"""A gap and a regulator's zero that move the first contact past readings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from diagnosis.data.files import written
from diagnosis.simulation.here import Here
from experiments import small

from dolfingrip.diagnosis import contact_shift
from dolfingrip.diagnosis.cautions import MESH_UNKNOWN
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, diagnose_measurement
from dolfingrip.experiments import run

PRESSURES_kPa = tuple(range(0, 51, 5))
NOISE_N = 0.003
TOLD = f"""experiment = "blocked_force"
[plate]
gap_mm = 0.6
[noise]
force_N = {NOISE_N}
pressure_kPa = 0.05
[noise.correlated]
force_N = {NOISE_N / 10}
"""
GAP_mm, OFFSET_kPa = 1.0, -2.0
SEED = 3


def measured(folder: Path) -> Path:
    """A finger whose plate is further away than told, and whose regulator's zero is off."""
    print("seed", SEED)
    config = small.short(
        f"plate.gap_mm={GAP_mm}", f"extensions.pressure_offset.offset_kPa={OFFSET_kPa}"
    )
    protocol = {"time_s": range(len(PRESSURES_kPa)), "pressure_kPa": PRESSURES_kPa}
    truth = run("blocked_force", config.changed(protocol=protocol))
    noise = NOISE_N * np.random.default_rng(SEED).standard_normal(len(PRESSURES_kPa))
    rows = zip(PRESSURES_kPa, truth.column("force_N") + noise, strict=True)
    lines = [f"{i},{p},{force:.6f}" for i, (p, force) in enumerate(rows)]
    return written(folder, "\n".join(["time_s,pressure_kPa,force_N", *lines]) + "\n", TOLD)


@pytest.mark.parametrize("moves", [True, False])
def test_a_moved_contact_is_no_cause(
    tmp_path: Path, moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The derivatives as told take what the contact does to readings for something unknown."""
    if not moves:
        monkeypatch.setattr(contact_shift, "needed", lambda *given: False)
    config = small.short()
    settings = Settings(effects=("force_gain", "force_offset"))
    measurement = read([measured(tmp_path)], config)
    found = diagnose_measurement(measurement, config, Here(tmp_path / "store"), settings)
    print(found.verdict.sentence(), found.none.by_key)
    left = found.none.residual(found.problem.value)
    white = found.none.covariance(found.problem).whiten(left)
    chi_squared = float(white @ white)
    assert MESH_UNKNOWN in found.warnings  # as the short finger's mesh is not graded
    print("chi squared", chi_squared, "of", len(left))
    if moves:
        assert found.verdict.answer == "none"
        assert len(found.problem.shifts) == 2
    else:
        assert chi_squared > 3 * len(left)
        assert not found.problem.shifts

"""A fit on a short finger: sought on the ungraded mesh, ended on the graded one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from diagnosis.data.files import written
from diagnosis.simulation.here import Here
from experiments import small

from dolfingrip.diagnosis.cautions import MESH_UNKNOWN
from dolfingrip.diagnosis.conclude import NONE
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, diagnose_measurement
from dolfingrip.diagnosis.simulation import meshes
from dolfingrip.experiments import run

PRESSURES_kPa = (0, 25, 50, 75, 100)
NOISE_deg = 0.003
HIDDEN_MPa = 1.8
SEED = 5
TOLD = f"""experiment = "bending"
[noise]
angle_deg = {NOISE_deg}
tip_x_mm = 0.001
[noise.correlated]
angle_deg = 0.0005
tip_x_mm = 0.0002
"""


def test_hidden_softening_is_found_at_its_strength(tmp_path: Path) -> None:
    """The truth was simulated on the graded mesh; the ungraded one alone would be off by more."""
    print("seed", SEED)
    config = small.short("mesh.edge_size_mm=4", "solver.rtol=1e-9")
    protocol = {"time_s": range(len(PRESSURES_kPa)), "pressure_kPa": PRESSURES_kPa}
    hidden = {"mooney_rivlin": {"C01_MPa": HIDDEN_MPa}}
    truth = run("bending", config.changed(protocol=protocol, extensions=hidden))
    rng = np.random.default_rng(SEED)
    angle_deg = truth.column("angle_deg") + NOISE_deg * rng.standard_normal(len(PRESSURES_kPa))
    tip_x_mm = truth.column("tip_x_mm") + 0.001 * rng.standard_normal(len(PRESSURES_kPa))
    lines = ["time_s,pressure_kPa,angle_deg,tip_x_mm"]
    lines += [
        f"{i},{pressure},{angle:.6f},{tip:.6f}"
        for i, (pressure, angle, tip) in enumerate(
            zip(PRESSURES_kPa, angle_deg, tip_x_mm, strict=True)
        )
    ]
    file = written(tmp_path, "\n".join(lines) + "\n", TOLD)
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
    left = found.problem.value - fit.predicted(found.problem, np.ones(len(angle_deg) * 2, bool))
    assert np.abs(left / found.problem.noise_std).max() == pytest.approx(0, abs=3.5)

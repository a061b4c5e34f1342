"""What a mesh that no graded one stands beside gets wrong is an unknown with its sign."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small
from support.delivered import delivered
from support.here import Here
from support.measured_files import written

from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.experiments import run
from dolfingrip.files.diagnosis_words import lines

PRESSURES_kPa = (0, 12.5, 25, 37.5, 50)
NOISE_deg = 0.01
SEED = 2
TOLD = f"""experiment = "bending"
[noise]
angle_deg = {NOISE_deg}
[nuisance]
wall = 0.001
pressure_gain = 0.001
pressure_offset_kPa = 0.05
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, store: Path) -> Diagnosis:
    """Readings of the model itself on the bisected mesh: it is off by its mesh alone."""
    print("seed", SEED)
    way = {"time_s": range(len(PRESSURES_kPa)), "pressure_kPa": PRESSURES_kPa}
    fine = run("bending", small.short("mesh.refine=2").changed(protocol=way)).column("angle_deg")
    fine = fine + NOISE_deg * np.random.default_rng(SEED).standard_normal(len(fine))
    lines = ["branch,time_s,pressure_kPa,angle_deg"]
    lines += [
        f"loading,{i},{pressure},{angle:.6f}"
        for i, (pressure, angle) in enumerate(zip(PRESSURES_kPa, fine, strict=True))
    ]
    file = written(tmp_path_factory.mktemp("lab"), "\n".join(lines) + "\n", TOLD)
    config = small.short()
    settings = DiagnosisSettings(quick=True, effects=("angle_gain",))
    return diagnose_measurement(read([file], config), config, Here(store), settings)


@pytest.mark.slow
def test_it_has_the_sign_and_the_size_of_what_a_finer_mesh_changes(found: Diagnosis) -> None:
    """Bisected once, the error falls by some half."""
    simulation = found.analysis.simulation
    change = found.analysis.problem.value - found.analysis.configured
    column = simulation.mesh
    print("error", column, "finer mesh less this one", change)
    assert (np.sign(column[2:]) == -np.sign(change[2:])).all()
    ratio = -column[2:] / change[2:]
    assert (ratio > 1.0).all()
    assert (ratio < 3.0).all()


@pytest.mark.slow
def test_moduli_are_no_surer_than_the_mesh(found: Diagnosis) -> None:
    """The truth is the configured modulus, which the coarse mesh by itself would exclude."""
    (mu, *_) = found.numbers(found.none)
    true = found.config.material.shear_MPa
    print(mu, "true", true)
    assert mu.key == "material.mu_MPa"
    assert mu.low < true < mu.high
    off = (found.analysis.problem.value - found.analysis.configured) / found.analysis.errors.noise
    assert np.linalg.norm(off) > 10


@pytest.mark.slow
def test_the_page_says_that_the_mesh_cannot_decide(found: Diagnosis, tmp_path: Path) -> None:
    result = delivered(found, tmp_path).result
    (told,) = result.misfit
    print(told)
    assert (told.channel, told.undecided) == ("angle_deg", True)
    column = found.analysis.simulation.mesh
    assert told.mesh == pytest.approx(np.sqrt(np.mean(column**2)))
    assert "this mesh cannot decide about angle_deg" in lines(result)[1]

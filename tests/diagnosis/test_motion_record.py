"""A record of a body that swings: read moment by moment, and no density is fitted to a lag."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.checkout import needs_checkout
from support.here import Here
from support.measured_files import written

from dolfingrip import config
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.simulated import groups
from dolfingrip.experiments import run
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest

SEED, TAU_S, NOISE_MM = 17, 0.02, 0.05
STL = Path(__file__).resolve().parents[2] / "examples" / "released_beam" / "beam.stl"
BEAM = {
    "finger.kind": "adopted", "adopted.length_mm": 100, "adopted.width_mm": 30,
    "adopted.depth_mm": 30, "adopted.solid_body": True, "morph.d_mm": 15,
    "material.mu_MPa": 0.09, "material.density_kg_m3": 1070, "contact.self_contact": False,
    "gravity.acceleration_m_s2": 9.81, "gravity.direction": [-1, 0, 0],
    "release.held_x_mm": 0.0, "experiment.dynamic": True, "solver.time_error_mm": 0.05,
    "extensions.loss_factor.loss_factor": 0.1,
}  # fmt: skip
TOLD = f'experiment = ["bending"]\n[noise]\ntip_x_mm = {NOISE_MM}\n'


def beam(folder: Path, size_mm: float, **further: Any) -> config.Config:
    """A beam of silicone that is held level and let go; keys have __ for a point."""
    mesh = folder / f"beam-{size_mm:g}.msh"
    if not mesh.exists():
        back = Asked(back=(-1.0, 0.0, 0.0))
        files.write(mesh, adopt(STL, back, MeshRequest(size_mm=size_mm)).mesh)
    keys = {key.replace("__", "."): value for key, value in further.items()}
    return config.load(None, {**BEAM, "mesh.file": str(mesh), **keys})


@needs_checkout
def test_each_row_is_simulated_at_its_time(tmp_path: Path) -> None:
    """Of a wait at rest its start and eight stops would do."""
    times = np.arange(0.0, 0.2, 0.01)
    rows = [f"{t:g},0,{np.cos(t):.6f}" for t in times]
    file = written(tmp_path, "\n".join(["time_s,pressure_kPa,tip_x_mm", *rows]), TOLD)
    still = beam(tmp_path, 40.0, experiment__dynamic=False, release__held_x_mm=None)
    for finger, count in ((beam(tmp_path, 40.0), len(times)), (still, 9)):
        (group,) = groups(read([file], finger), finger)
        schedule = group.schedule(group.config)
        assert len(schedule.value) == count
        if finger.experiment.dynamic:
            np.testing.assert_allclose(schedule.time_s, times, atol=1e-12)
            there = np.random.default_rng(SEED).standard_normal(count)
            np.testing.assert_allclose(schedule.at_rows(there, count), there, atol=1e-12)


@pytest.mark.slow
@needs_checkout
def test_no_density_is_fitted_to_a_lag(tmp_path: Path, store: Path) -> None:
    """The filter of a camera shows a swing late and smaller; truth on another mesh."""
    print("seed", SEED)
    times = np.arange(0.0, 0.2001, 0.01)
    truth = beam(
        tmp_path, 25.0, extensions__sensor_lag__tau_s=TAU_S, solver__time_error_mm=0.005,
        protocol__time_s=times.tolist(), protocol__pressure_kPa=[0.0] * len(times),
    )  # fmt: skip
    seen = run("bending", truth).column("tip_x_mm")
    seen += NOISE_MM * np.random.default_rng(SEED).standard_normal(len(times))
    rows = [f"{t:g},0,{x:.6f}" for t, x in zip(times, seen, strict=True)]
    file = written(tmp_path, "\n".join(["time_s,pressure_kPa,tip_x_mm", *rows]), TOLD)
    model = beam(tmp_path, 30.0)
    settings = DiagnosisSettings(effects=("sensor_lag", "density"), quick=True)
    found = diagnose_measurement(read([file], model), model, Here(store), settings)
    assert (found.decision.answer, found.decision.first) == ("cause", ("sensor_lag",))
    assert found.decision.inclusion["density"] < 0.05
    numbers = {number.key: number for number in found.numbers(found.decision.best)}
    print(numbers)
    tau, density = numbers["extensions.sensor_lag.tau_s"], numbers["material.density_kg_m3"]
    assert tau.low < TAU_S < tau.high
    assert abs(density.value / 1070 - 1) < 0.06

"""A record of a body that swings: read moment by moment, and no density is fitted to a lag."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import cast_beam
from support.checkout import needs_checkout
from support.here import Here
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.simulated import groups
from dolfingrip.experiments import run

SEED, TAU_S, NOISE_MM = 17, 0.02, 0.05
MOVING = {
    "gravity__acceleration_m_s2": 9.81, "gravity__direction": [-1, 0, 0],
    "release__held_x_mm": 0.0, "experiment__dynamic": True, "solver__time_error_mm": 0.05,
    "extensions__loss_factor__loss_factor": 0.1,
}  # fmt: skip
TOLD = f'experiment = ["bending"]\n[noise]\ntip_x_mm = {NOISE_MM}\n'


def beam(folder: Path, size_mm: float, **further: Any) -> Config:
    """The beam, held level and let go; keys have __ for a point."""
    return cast_beam.beam(folder, size_mm, **{**MOVING, **further})


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

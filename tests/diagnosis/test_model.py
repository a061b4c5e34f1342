"""Readings with effects whose parameters are free: which simulations they take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from diagnosis.data.files import written
from diagnosis.simulation.here import Here
from experiments import small

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.model import EffectModel, free_parameters, modulus_parameter
from dolfingrip.diagnosis.simulation.job import Job, JobResult
from dolfingrip.diagnosis.simulation.simulated import Case, simulate

PRESSURES_kPa = (0, 20, 40, 20, 0)
TOLD = """experiment = ["bending", "blocked_force"]
[noise]
angle_deg = 0.3
force_N = 0.02
[plate]
gap_mm = 0.1
"""
MU, MODULUS = 0.5, 1.1


@dataclass(frozen=True, slots=True)
class Listening(Here):
    """Workers that keep what they are asked for."""

    asked: list[Job] = field(default_factory=list)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        self.asked.extend(jobs)
        return Here.results(self, jobs)


def finger() -> Config:
    """Two bellows."""
    return small.short("solver.rtol=1e-9")


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    lines = ["experiment,branch,time_s,pressure_kPa,angle_deg,force_N"]
    for name, entry in (("bending", "1.0,"), ("blocked_force", ",1.0")):
        for i, pressure in enumerate(PRESSURES_kPa):
            branch = "loading" if i < 3 else "unloading"
            lines.append(f"{name},{branch},{i},{pressure},{entry}")
    file = written(tmp_path_factory.mktemp("model"), "\n".join(lines) + "\n", TOLD)
    return read([file], finger())


def test_an_effect_is_simulated_where_it_is_felt(measurement: Measurement, store: Path) -> None:
    """A free finger feels no plate: it is loaded alone, and its readings are the same."""
    config, workers = finger(), Listening(store)
    effects = free_parameters("plate_friction", (f"extensions.plate_friction.mu={MU}",), config)
    scale = modulus_parameter(measurement, config)
    model = EffectModel(measurement, config, workers, scale, effects)
    readings, slopes = model.evaluate([MODULUS, MU])

    by_name = {job.experiment: job for job in workers.asked}
    assert [effect.name() for effect in by_name["bending"].config.extensions.active()] == []
    assert by_name["blocked_force"].config.extensions.plate_friction.mu == MU
    stops = {name: len(job.config.protocol.pressure_kPa) for name, job in by_name.items()}
    assert stops["bending"] < stops["blocked_force"]

    keys = ("extensions.plate_friction.mu", "material.mu_MPa")
    everywhere = Case(model.overrides([MODULUS, MU]), keys)
    (other,) = simulate(measurement, config, [everywhere], workers)
    free = (measurement.listed()["column"] == "angle_deg").to_numpy()
    assert readings == pytest.approx(other.readings, rel=1e-5)
    assert np.abs(slopes[free, 1]).max() == 0.0
    assert slopes[:, 1] == pytest.approx(other.slope(keys[0]), abs=1e-9)
    assert np.abs(slopes[~free, 1]).max() > 1e-4
    assert slopes[free, 0] == pytest.approx(
        other.slope(keys[1])[free] * config.material.shear_MPa, rel=1e-3, abs=1e-6
    )

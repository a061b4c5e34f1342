"""Frequencies and damping ratios in place of a record: read, derived and diagnosed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.cast_beam import beam
from support.checkout import needs_checkout
from support.here import Here
from support.measured_files import written

from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.simulated import groups
from dolfingrip.experiments import run
from dolfingrip.parameter import find

SEED, LOSS, HEAVY_G = 5, 0.15, 52.0
NOISE = {"frequency_1_Hz": 0.03, "damping_ratio_1": 0.003}
TOLD = 'experiment = "vibration"\n[noise]\n' + "".join(f"{k} = {v}\n" for k, v in NOISE.items())


def measured(folder: Path, name: str, row: dict[str, float], told: str = "") -> Path:
    """The file of one state."""
    (own := folder / name).mkdir()
    text = f"specimen,pressure_kPa,{','.join(row)}\nbeam,0,{','.join(map(str, row.values()))}\n"
    return written(own, text, TOLD + told)


@needs_checkout
def test_a_table_of_frequencies_is_read(tmp_path: Path) -> None:
    """It is simulated at rest, whatever else moves; what is felt in motion is felt."""
    row = dict.fromkeys(NOISE, 0.5)
    mass = f"[extensions.tip_mass]\nmass_g = {HEAVY_G}\n"
    file = measured(tmp_path, "heavy", row, mass)
    moving = beam(
        tmp_path, 40.0, experiment__dynamic=True, release__held_x_mm=0.0, base__time_s=[0.0, 1.0],
        base__acceleration_m_s2=[0.0, 1.0],
    )  # fmt: skip
    measurement = read([file], moving)
    assert {*measurement.listed["column"]} == {*NOISE}
    (there,), (group,) = measurement.applied(moving), groups(measurement, moving)
    assert there.experiment.dynamic
    assert not group.config.experiment.dynamic
    assert not group.config.release.acts
    assert not group.config.base.time_s
    assert group.config.extensions.tip_mass.mass_g == HEAVY_G


@needs_checkout
def test_derivatives(tmp_path: Path) -> None:
    """Against central differences of two further runs."""
    keys = ("material.mu_MPa", "material.density_kg_m3", "extensions.loss_factor.loss_factor",
            "extensions.tip_mass.mass_g")  # fmt: skip
    at = beam(
        tmp_path, 40.0, extensions__loss_factor__loss_factor=LOSS,
        extensions__tip_mass__mass_g=HEAVY_G, experiment__max_pressure_kPa=1.0,
        experiment__step_kPa=1.0,
    )  # fmt: skip
    found = run("vibration", at, gradients=keys).sensitivities
    for parameter in find(at, keys):
        value, change = parameter.value(at), 1e-3 * parameter.scale
        ends = [run("vibration", parameter.at(at, value + sign * change)) for sign in (-1, 1)]
        for name in NOISE:
            low, high = (end.column(name)[0] for end in ends)
            expected = (high - low) / (2 * change)
            apart = abs(found[name, parameter.key][0] - expected) * parameter.scale
            # the rounding of the modes is 1e-3 of a damping ratio
            assert apart < 0.005 * abs(expected) * parameter.scale + 2e-3 * low


@pytest.mark.slow
@needs_checkout
def test_damping_names_the_loss(tmp_path: Path, store: Path) -> None:
    """Two states, with and without a mass that is told; the truth on a finer mesh."""
    print("seed", SEED)
    rng, given = np.random.default_rng(SEED), []
    for name, mass_g in (("bare", 0.0), ("heavy", HEAVY_G)):
        on = {"extensions__tip_mass__mass_g": mass_g} if mass_g else {}
        truth = run("vibration", beam(
            tmp_path, 30.0, extensions__loss_factor__loss_factor=LOSS,
            experiment__max_pressure_kPa=1.0, experiment__step_kPa=1.0, **on,
        ))  # fmt: skip
        row = {
            key: truth.column(key)[0] + std * rng.standard_normal() for key, std in NOISE.items()
        }
        told = f"[extensions.tip_mass]\nmass_g = {mass_g}\n" if mass_g else ""
        given.append(measured(tmp_path, name, row, told))
    model = beam(tmp_path, 40.0)
    settings = DiagnosisSettings(effects=("loss_factor", "density"))
    found = diagnose_measurement(read(given, model), model, Here(store), settings)
    assert (found.decision.answer, found.decision.first) == ("cause", ("loss_factor",))
    (loss,) = (n for n in found.numbers(found.decision.best) if n.key.endswith("loss_factor"))
    print(loss)
    assert loss.low < LOSS < loss.high

"""From the regulator to the cavity."""

from __future__ import annotations

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI
from support import trial
from support.supply import TAU, cavity_pressures

from dolfingrip import config
from dolfingrip.config import KPA, ConfigError
from dolfingrip.experiments import run
from dolfingrip.extensions.force_gain import ForceGain
from dolfingrip.extensions.pressure_gain import PressureGain
from dolfingrip.extensions.set_point_logged import SetPointLogged
from dolfingrip.extensions.supply import Supply
from dolfingrip.mechanics.model.model import Control
from dolfingrip.sections.tables import assignments


@pytest.mark.parametrize("steps", [1, 7, 100])
def test_ramp_through_a_line(steps: int) -> None:
    """p = k (t − τ (1 − exp(−t/τ))), whatever the steps."""
    times = np.linspace(0, 2, steps + 1)[1:]
    expected = 30 * (times - TAU * (1 - np.exp(-times / TAU)))
    np.testing.assert_allclose(cavity_pressures(times, 30 * times), expected, rtol=1e-10)


def test_sudden_pressure_through_a_line() -> None:
    """p = p₀ (1 − exp(−t/τ))."""
    times = np.array([1e-9, 0.3, 0.7, 1.4, 7.0])
    expected = 100 * (1 - np.exp(-times / TAU))
    np.testing.assert_allclose(
        cavity_pressures(times, np.full(5, 100.0)), expected, rtol=1e-8, atol=1e-6
    )


def test_stages_follow_one_another_and_can_be_taken_back() -> None:
    times = np.linspace(0, 2, 9)[1:]
    stages = (PressureGain(gain=1.5), SetPointLogged(tau_s=TAU))
    np.testing.assert_allclose(
        cavity_pressures(times, 20 * times, *stages),
        cavity_pressures(times, 30 * times),
        rtol=1e-12,
    )
    cavity = Control(fem.Constant(mesh.create_unit_interval(MPI.COMM_SELF, 1), 0.0), KPA)
    supply = Supply(cavity, stages)
    kept = supply.values()
    ends = []
    for _ in range(2):
        for time_s in (0.5, 1.0):
            supply.set(40 * time_s)
            supply.set_time(time_s, 0.5)
            supply.accept()
        ends.append(cavity.value)
        supply.set(0.0)
        supply.restore(kept)
    assert ends[0] == ends[1] > 1.0


def test_volume_control_has_no_regulator() -> None:
    settings = trial.configured({PressureGain: {}}, "experiment.control=volume")
    with pytest.raises(ConfigError, match=r"extensions.pressure_gain: allowed: with experiment"):
        run("bending", settings, comm=MPI.COMM_SELF)


def test_moduli_gain_and_force_gain_cancel_exactly() -> None:
    """Without gravity: moduli × c, pressure × c, force × 1/c change no angle and no force."""
    c = 1.3
    common = (*trial.STRICT, "experiment.step_kPa=25", "extensions.prony.tau_s=[3]")
    base = config.load(
        None, assignments([*trial.small.SHORT, *common, "extensions.mooney_rivlin.C01_MPa=1"])
    )
    scaled = base.changed(
        material={"mu_MPa": c * base.material.mu_MPa},
        contact={"stiffness_MPa": c * base.contact.stiffness_MPa},
        plate={"stiffness_MPa": c * base.plate.stiffness_MPa},
        extensions={
            "mooney_rivlin": {"C01_MPa": c},
            "pressure_gain": PressureGain(gain=c).model_dump(),
            "force_gain": ForceGain(gain=1 / c).model_dump(),
        },
    )
    first, second = (run("blocked_force", s, comm=MPI.COMM_SELF) for s in (base, scaled))
    assert first.failure is second.failure is None
    assert first.column("force_N")[-1] > 0.5
    for name in ("angle_deg", "force_N", "tip_x_mm"):
        scale = np.abs(first.column(name)).max()
        np.testing.assert_allclose(
            second.column(name), first.column(name), rtol=0, atol=1e-9 * scale
        )

"""From the sensor to the table, and moduli that drift."""

from __future__ import annotations

import numpy as np
import pytest
from support import bars, small
from support.supply import cavity_pressures

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.extensions.pressure_offset import PressureOffset
from dolfingrip.extensions.set_point_logged import SetPointLogged
from dolfingrip.sections.tables import assignments

ROW = {"time_s": 30.0, "angle_deg": 40.0, "chord_angle_deg": 21.0, "force_N": 2.0}


def shown(*overrides: str) -> dict[str, float]:
    """The row as the instruments display it."""
    settings = config.load(None, assignments([f"extensions.{override}" for override in overrides]))
    rows = {name: np.array([value]) for name, value in ROW.items()}
    return {name: float(values[-1]) for name, values in settings.extensions.displayed(rows).items()}


def test_force() -> None:
    found = shown("zero_drift.force_N_per_s=0.01", "force_offset.offset_N=0.1", "force_gain.gain=2")
    # the gain comes first: what is added is added to the displayed force
    assert found["force_N"] == pytest.approx(2 * 2.0 + 0.1 + 0.01 * 30)
    assert found["angle_deg"] == 40.0


def test_angle() -> None:
    found = shown(
        "angle_offset.offset_deg=1", "angle_gain.gain=1.5", "angle_definition.chord_share=0.25"
    )
    assert found["angle_deg"] == pytest.approx(1.5 * (0.75 * 40 + 0.25 * 21) + 1)
    assert found["force_N"] == 2.0


def test_an_angle_that_lags() -> None:
    """On a ramp of rate r from rest α − rτ (1 − exp(−t/τ)), in a wait an exponential towards α."""
    rate, tau = 4.0, 0.5
    ramp, wait = np.array([0.2, 1.0, 2.5]), np.array([2.5, 3.0, 6.0])
    time_s = np.concatenate([[0.0], ramp, wait])
    true = {"time_s": time_s, "angle_deg": rate * np.minimum(time_s, 2.5)}
    settings = config.load(None, assignments([f"extensions.sensor_lag.tau_s={tau}"]))
    found = settings.extensions.displayed(true)["angle_deg"]
    behind = rate * tau * (1 - np.exp(-ramp / tau))
    np.testing.assert_allclose(found[1:4], rate * ramp - behind, rtol=1e-12)
    np.testing.assert_allclose(found[4:], 10 - behind[-1] * np.exp((2.5 - wait) / tau), rtol=1e-12)
    assert found[0] == 0.0
    offset = config.load(
        None, assignments(["extensions.sensor_lag.tau_s=0", "extensions.angle_offset.offset_deg=1"])
    )
    np.testing.assert_array_equal(
        offset.extensions.displayed(true)["angle_deg"], true["angle_deg"] + 1
    )


def test_the_rig_shows_an_angle_that_lags() -> None:
    """A cycle against its own readings without the lag; the force as it is."""
    cycle = ("protocol.time_s=[0, 0.1, 0.2, 0.9, 1.0]", "protocol.pressure_kPa=[0, 10, 20, 20, 0]")
    quick = ("plate.gap_mm=0.1", *cycle)
    base = run("blocked_force", small.short(*quick))
    late = run("blocked_force", small.short(*quick, "extensions.sensor_lag.tau_s=0.3"))
    settings = config.load(None, assignments(["extensions.sensor_lag.tau_s=0.3"]))
    true = {name: base.column(name) for name in ("time_s", "angle_deg", "tip_x_mm")}
    for name in ("angle_deg", "tip_x_mm"):
        found, off = late.column(name), base.column(name)
        np.testing.assert_allclose(found, settings.extensions.displayed(true)[name], rtol=1e-12)
        assert np.abs(found - off).max() > 0.1 * np.abs(off).max()
    np.testing.assert_array_equal(late.column("force_N"), base.column("force_N"))


def test_pressure_offset_is_there_from_the_start() -> None:
    """A line behind it is filled at first."""
    times = np.array([1.0, 2.0])
    stages = (PressureOffset(offset_kPa=3.0), SetPointLogged(tau_s=0.7))
    np.testing.assert_allclose(cavity_pressures(times, np.zeros(2), *stages), 3.0)


def test_moduli_drift_with_temperature() -> None:
    """σ(t) = (1 + c ΔT (1 − exp(−t/τ))) σ(0) of a bar held at a stretch."""
    slope, warming, tau = -0.01, 4.0, 20.0
    names = {"modulus_per_degC": slope, "warming_degC": warming, "tau_s": tau}
    times = np.array([0.0, 5.0, 20.0, 100.0])
    result = bars.pull(
        *(f"extensions.temperature_drift.{key}={value}" for key, value in names.items()),
        *bars.protocol(times, np.full(4, 10.0)),
    )
    found = result.column("nominal_stress_MPa")
    assert found[0] > 1
    factor = 1 + slope * warming * (1 - np.exp(-times / tau))
    np.testing.assert_allclose(found / found[0], factor, rtol=1e-7)

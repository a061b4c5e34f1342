"""Friction between bellows that touch, in two cycles of a short finger against the plate."""

from __future__ import annotations

import numpy as np
import pytest
from support import trial

from dolfingrip.config import Contact
from dolfingrip.experiments import Result, run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.mechanics.contact.friction import SLIP_MM

CYCLES = (
    "finger.gap_mm=0.4",
    "experiment.max_pressure_kPa=100",
    "experiment.step_kPa=25",
    "experiment.cycles=2",
)
APART_kPa = 25.0
"""Highest reading at which no bellows touch."""
READINGS = ("force_N", "angle_deg", "cavity_volume_mm3")


def blocked(coefficient: float | None, *overrides: str) -> Result:
    on = {} if coefficient is None else {BellowsFriction: {"coefficient": coefficient}}
    found = run("blocked_force", trial.configured(on, *CYCLES, *overrides), comm=trial.SELF)
    assert found.failure is None
    assert found.column("load_steps").max() == 1
    return found


@pytest.fixture(scope="module")
def smooth() -> Result:
    """Without the effect."""
    return blocked(None)


@pytest.fixture(scope="module")
def rough() -> Result:
    """With it."""
    return blocked(0.6)


@pytest.mark.slow
def test_two_cycles(smooth: Result, rough: Result) -> None:
    """Nothing before the bellows touch; from the first touch on a loop, the same in both cycles."""
    pressure, gap = rough.column("pressure_kPa"), rough.column("contact_gap_mm")
    top = int(np.argmax(pressure))
    early = np.flatnonzero(pressure[:top] <= APART_kPa)
    first = early[-1] + 1
    width = Contact().barrier_mm
    assert gap[early[-1]] > width > gap[first]
    for name in READINGS:
        change = rough.column(name) - smooth.column(name)
        scale = np.abs(smooth.column(name)).max()
        np.testing.assert_allclose(change[early], 0, atol=1e-6 * scale)
        assert np.abs(change).max() > 1e-4 * scale
        assert np.abs(change[first]) > 1e-5 * scale  # the step of the first touch rubs
        # bellows part as the finger is vented, so nothing is left for the second cycle
        np.testing.assert_allclose(change[2 * top :], change[: 2 * top + 1], atol=1e-5 * scale)
    force = rough.column("force_N")
    assert pressure[top - 1] == pressure[top + 1]
    assert abs(force[top + 1] - force[top - 1]) > 1e-4 * force.max()


@pytest.mark.slow
def test_it_takes_few_iterations(rough: Result) -> None:
    """72, and 58 without friction."""
    assert rough.facts.newton.iterations <= 74


@pytest.mark.slow
def test_half_the_step_leads_to_the_same(rough: Result) -> None:
    once = ("experiment.cycles=1", "experiment.unload=true", "experiment.step_kPa=12.5")
    fine = blocked(0.6, *once)
    for name in READINGS:
        found = fine.column(name)[::2]
        expected = rough.column(name)[: len(found)]
        print(name, (found - expected) / np.ptp(expected))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3 * np.ptp(expected))


def test_without_a_coefficient_it_is_the_base_model() -> None:
    base, found = (blocked(mu, *trial.STRICT, "experiment.cycles=1") for mu in (None, 0.0))
    for name in READINGS:
        scale = np.abs(base.column(name)).max()
        np.testing.assert_allclose(found.column(name), base.column(name), atol=1e-9 * scale)


def test_its_elastic_displacement_is_that_on_the_plate() -> None:
    assert BellowsFriction().slip_mm == SLIP_MM

"""Friction between bellows that touch, in two cycles of a short finger against the plate."""

from __future__ import annotations

import numpy as np
import pytest
from experiments import small
from extensions import trial

from dolfingrip.config import Contact
from dolfingrip.experiments import Result, run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.mechanics.contact.barrier import BarrierContact

CYCLES = (
    "finger.gap_mm=0.4",
    "experiment.max_pressure_kPa=100",
    "experiment.step_kPa=25",
    "experiment.cycles=2",
)
TOUCH_kPa = 50.0
"""Highest reading at which no bellows have touched a step before."""
READINGS = ("force_N", "angle_deg", "cavity_volume_mm3")


def blocked(coefficient: float | None) -> Result:
    on = {} if coefficient is None else {BellowsFriction: {"coefficient": coefficient}}
    return run("blocked_force", trial.configured(on, *CYCLES), comm=trial.SELF)


@pytest.fixture(scope="module")
def smooth() -> Result:
    """Without the effect."""
    return blocked(None)


def test_two_cycles(smooth: Result) -> None:
    """No step fails; nothing before the bellows touch; there a loop, the same in both cycles."""
    rough = blocked(0.6)
    assert smooth.failure is rough.failure is None
    assert rough.column("load_steps").max() == 1
    pressure, gap = rough.column("pressure_kPa"), rough.column("contact_gap_mm")
    top = int(np.argmax(pressure))
    early = np.flatnonzero(pressure[:top] <= TOUCH_kPa)
    width = Contact().barrier_mm
    assert gap[early[-2]] > width > gap[early[-1]]  # they touch at the last of these
    for name in READINGS:
        change = rough.column(name) - smooth.column(name)
        scale = np.abs(smooth.column(name)).max()
        np.testing.assert_allclose(change[early], 0, atol=1e-7 * scale)
        assert np.abs(change).max() > 1e-4 * scale
        # bellows part as the finger is vented, so nothing is left for the second cycle
        np.testing.assert_allclose(change[2 * top :], change[: 2 * top + 1], atol=1e-6 * scale)
    force = rough.column("force_N")
    assert pressure[top - 1] == pressure[top + 1]
    assert abs(force[top + 1] - force[top - 1]) > 1e-4 * force.max()


def test_without_a_coefficient_it_is_the_base_model() -> None:
    for coefficient, kind in ((0.0, True), (0.6, False)):
        on = {BellowsFriction: {"coefficient": coefficient}}
        contact = small.model(trial.configured(on), plate=False).contact
        assert (type(contact) is BarrierContact) == kind

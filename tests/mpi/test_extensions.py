"""Effects on any number of ranks; the reference is the same model on one."""

from __future__ import annotations

import numpy as np
import pytest
from extensions import trial
from mpi4py import MPI

from dolfingrip import config
from dolfingrip.experiments import Result, run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.extensions.mooney_rivlin import MooneyRivlin
from dolfingrip.extensions.plate_friction import PlateFriction

WORLD = MPI.COMM_WORLD
CYCLES = (
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=20",
    "experiment.cycles=2",
)

TOUCHING = (
    "finger.gap_mm=0.3",
    "experiment.max_pressure_kPa=75",
    "experiment.step_kPa=25",
    "experiment.unload=true",
)


def _compare(alone: Result, together: Result, *names: str) -> None:
    assert alone.failure is together.failure is None
    assert len(alone.rows) == len(together.rows)
    for name in names:
        expected, found = alone.column(name), together.column(name)
        scale = np.nanmax(np.abs(expected))
        assert scale > 0
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * scale, err_msg=name)


def test_a_finger_with_all_other_than_elastic_effects_at_once() -> None:
    """One of the elastic effects is the base of the others."""
    on = [effect for effect in EFFECTS if effect.kind != "elastic" or effect is MooneyRivlin]
    settings = trial.configured({effect: {} for effect in on}, *trial.STRICT, *CYCLES)
    alone, together = (run("blocked_force", settings, comm=comm) for comm in (trial.SELF, WORLD))
    _compare(alone, together, "angle_deg", "force_N", "tip_x_mm", "cavity_pressure_kPa")


def test_a_finger_with_all_elastic_effects_at_once() -> None:
    on = [effect for effect in EFFECTS if effect.kind == "elastic"]
    once = (*trial.STRICT, *CYCLES, "experiment.cycles=1")  # they have no memory
    settings = trial.configured({effect: {} for effect in on}, *once)
    alone, together = (run("blocked_force", settings, comm=comm) for comm in (trial.SELF, WORLD))
    _compare(alone, together, "angle_deg", "force_N", "tip_x_mm")


def test_bellows_and_a_plate_that_rub() -> None:
    settings = trial.configured({BellowsFriction: {}, PlateFriction: {}}, *trial.STRICT, *TOUCHING)
    alone, together = (run("blocked_force", settings, comm=comm) for comm in (trial.SELF, WORLD))
    gap = alone.column("contact_gap_mm")
    assert (gap < settings.contact.barrier_mm).sum() > 2
    _compare(alone, together, "angle_deg", "force_N", "tip_x_mm", "contact_gap_mm")


@pytest.mark.parametrize("grip", ["sliding", "clamped"])
def test_a_coupon_that_relaxes(grip: str) -> None:
    settings = config.load(
        None,
        [*trial.STRICT, "extensions.prony.tau_s=[2]", "experiment.unload=true",
         "experiment.hold_s=5", "coupon.gauge_length_mm=9", "coupon.step_strain=0.25",
         f"coupon.grip={grip}"],
    )  # fmt: skip
    alone, together = (run("coupon", settings, comm=comm) for comm in (trial.SELF, WORLD))
    _compare(alone, together, "force_N", "nominal_stress_MPa", "transverse_strain")

"""Effects: any number of ranks find what one found."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from support import stored, trial

from dolfingrip import config
from dolfingrip.experiments import Result, run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.extensions.mooney_rivlin import MooneyRivlin
from dolfingrip.extensions.plate_friction import PlateFriction
from dolfingrip.sections.tables import assignments

pytestmark = pytest.mark.two_ranks

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


def _compare(case: str, result: Result, *names: str) -> None:
    assert result.failure is None
    found = {name: result.column(name) for name in names}
    for name, values in found.items():
        assert np.nanmax(np.abs(values)) > 0, name
    stored.compare(case, found, rtol=1e-8, by_scale=True)


def test_a_finger_with_all_other_than_elastic_effects_at_once() -> None:
    """One of the elastic effects is the base of the others."""
    on = [effect for effect in EFFECTS if effect.kind != "elastic" or effect is MooneyRivlin]
    settings = trial.configured({effect: {} for effect in on}, *trial.STRICT, *CYCLES)
    result = run("blocked_force", settings, comm=WORLD)
    _compare("other effects", result, "angle_deg", "force_N", "tip_x_mm", "cavity_pressure_kPa")


def test_a_finger_with_all_elastic_effects_at_once() -> None:
    on = [effect for effect in EFFECTS if effect.kind == "elastic"]
    once = (*trial.STRICT, *CYCLES, "experiment.cycles=1")  # they have no memory
    settings = trial.configured({effect: {} for effect in on}, *once)
    result = run("blocked_force", settings, comm=WORLD)
    _compare("elastic effects", result, "angle_deg", "force_N", "tip_x_mm")


def test_bellows_and_a_plate_that_rub() -> None:
    settings = trial.configured({BellowsFriction: {}, PlateFriction: {}}, *trial.STRICT, *TOUCHING)
    result = run("blocked_force", settings, comm=WORLD)
    gap = result.column("contact_gap_mm")
    assert (gap < settings.contact.barrier_mm).sum() > 2
    _compare("friction", result, "angle_deg", "force_N", "tip_x_mm", "contact_gap_mm")


@pytest.mark.parametrize("grip", ["sliding", "clamped"])
def test_a_coupon_that_relaxes(grip: str) -> None:
    settings = config.load(
        None,
        assignments([*trial.STRICT, "extensions.prony.tau_s=[2]", "experiment.unload=true",
         "experiment.hold_s=5", "coupon.gauge_length_mm=9", "coupon.step_strain=0.25",
         f"coupon.grip={grip}"]),
    )  # fmt: skip
    result = run("coupon", settings, comm=WORLD)
    names = ("force_N", "nominal_stress_MPa", "transverse_strain")
    _compare(f"a coupon that relaxes, {grip}", result, *names)

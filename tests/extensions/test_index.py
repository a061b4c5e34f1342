"""What every effect in the index must have and do; a new one is tested here by being there."""

from __future__ import annotations

import numpy as np
import pytest
from support import trial

from dolfingrip.experiments import Result, run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.extensions.density import BodyDensity
from dolfingrip.extensions.effect import (
    Adapting,
    Displaying,
    Effect,
    Energetic,
    Joining,
    Stage,
    Uneven,
)
from dolfingrip.extensions.index import EFFECTS, NAMES
from dolfingrip.extensions.kinds import AirLineChange
from dolfingrip.extensions.no_self_contact import NoSelfContact
from dolfingrip.extensions.plate_friction import PlateFriction
from dolfingrip.extensions.tip_mass import TipMass
from dolfingrip.parameter.search import PRINTED_MPa, scaled_priors

OF_CONTACT = (BellowsFriction, NoSelfContact)
"""Tested where bellows touch: ``test_bellows_friction.py``, ``test_setup.py``."""

OF_WEIGHT = (TipMass, BodyDensity)
"""Felt under gravity and in motion: ``mechanics/test_inertia.py``."""

OF_SUPPLY = tuple(effect for effect in EFFECTS if issubclass(effect, AirLineChange))
"""Felt where air flows through a line: ``test_air_line.py``."""

NO_FORMS = (BellowsFriction, PlateFriction)
"""With a term of their own: ``test_contact_friction.py``, ``test_plate_friction.py``."""

SMOOTH = {"permanent_set": {"yield_strain": 0.005}}
"""All points yield: remainders across the kink where one begins to are of second order, but not
evenly so."""

HOOKS = (Adapting, Energetic, Joining, Stage, Displaying, Uneven)

TWO_CYCLES = (
    "finger.bellows=1",
    "finger.length_mm=26",
    "mesh.size_mm=12",
    "mesh.edge_size_mm=12",
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=20",
    "protocol.time_s=[0, 0.8, 2.8, 3.2, 3.6, 5.6, 6.4]",
    "protocol.pressure_kPa=[0, 20, 20, 10, 20, 20, 0]",
    "protocol.cycle=[1, 1, 1, 1, 2, 2, 2]",
)
READINGS = ("angle_deg", "force_N", "tip_x_mm", "tip_z_mm", "cavity_volume_mm3")

every = pytest.mark.parametrize("effect", EFFECTS, ids=NAMES)

ENERGIES = [
    effect
    for effect in EFFECTS
    if issubclass(effect, Energetic | Joining | Uneven) and effect not in NO_FORMS
]


def blocked(effect: type[Effect] | None, *overrides: str, neutral: bool = False) -> Result:
    """Two cycles against the plate."""
    on = {} if effect is None else {effect: effect.neutral if neutral else {}}
    return run("blocked_force", trial.configured(on, *overrides), comm=trial.SELF)


@pytest.fixture(scope="module")
def base() -> Result:
    """The model without any effect."""
    return blocked(None, *TWO_CYCLES, *trial.STRICT)


@every
def test_says_what_it_is(effect: type[Effect]) -> None:
    text = effect.__doc__ or ""
    for part in ("Prior:", "Fingerprint:", "Confused with:"):
        assert part in text, part
    assert any(sign in text for sign in "=←+"), "no equation"
    assert effect.kind
    assert issubclass(effect, HOOKS)
    assert not (
        issubclass(effect, Adapting) and sum(issubclass(effect, hook) for hook in HOOKS) > 1
    )
    numbers = {key for key, info in effect.model_fields.items() if info.annotation is not bool}
    assert numbers == set(effect.priors()), "a parameter without a prior"
    for prior in effect.priors().values():
        assert prior.source
        assert prior.spread > 0
        assert not prior.positive or prior.mean > 0
    for info in effect.model_fields.values():
        assert info.description
    silicone = scaled_priors(effect, 0.02)
    for key, prior in effect.priors().items():
        factor = 0.02 / PRINTED_MPa if key.endswith("_MPa") else 1.0
        assert silicone[key].mean == pytest.approx(factor * prior.mean)
        assert silicone[key].spread == pytest.approx(factor * prior.spread)


@pytest.mark.parametrize("effect", ENERGIES, ids=[effect.name() for effect in ENERGIES])
def test_derivatives(effect: type[Effect]) -> None:
    on = {effect: SMOOTH.get(effect.name(), {})}
    finger = trial.stirred(trial.configured(on, "plate.gap_mm=30", *TWO_CYCLES))
    assert f"extensions.{effect.name()}" in " ".join(finger.parameters)
    energy, residual = trial.orders(finger)
    assert energy > 1.9
    assert residual > 1.9


@every
def test_neutral_is_the_base_model(effect: type[Effect], base: Result) -> None:
    """To where Newton's iterations end: 1e-12 of the residual."""
    found = blocked(effect, *TWO_CYCLES, *trial.STRICT, neutral=True)
    assert found.failure is None
    for name in READINGS:
        expected = base.column(name)
        scale = np.abs(expected).max()
        assert scale > 0
        np.testing.assert_allclose(found.column(name), expected, rtol=0, atol=1e-9 * scale)


@every
def test_two_cycles_without_a_failed_step(effect: type[Effect], base: Result) -> None:
    found = blocked(effect, *TWO_CYCLES)
    assert found.failure is None
    assert found.column("cycle").max() == 2
    # one load step for each reading: none was cut
    assert found.column("load_steps").max() == 1
    if effect in (*OF_CONTACT, *OF_WEIGHT, *OF_SUPPLY):
        return
    changes = [
        np.abs(found.column(name) - base.column(name)).max() / np.abs(base.column(name)).max()
        for name in READINGS
    ]
    assert max(changes) > 1e-6

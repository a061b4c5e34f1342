"""Work that the air does on a finger in a closed cycle: what the dissipative effects take of it."""

from __future__ import annotations

import numpy as np
import pytest
from support import trial

from dolfingrip.experiments import run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS

CYCLES = (
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=10",
    "experiment.cycles=2",
)
TOUCHING = ("finger.gap_mm=0.15", "contact.self_contact=true", "experiment.step_kPa=5")
"""Bellows near enough to touch at these pressures, for what acts where they do."""
DISSIPATIVE = [effect for effect in EFFECTS if effect.kind == "dissipative"]
YIELDING = {"yield_strain": 0.005}
"""Below the small strains of this finger."""
ONCE = ("mullins",)
"""What is softened does not soften again up to the same pressure."""


def given(effect: type[Effect]) -> dict[type[Effect], dict[str, float]]:
    return {effect: YIELDING if effect.name() == "permanent_set" else {}}


def felt(effect: type[Effect]) -> tuple[str, ...]:
    return TOUCHING if effect is BellowsFriction else ()


def work(on: dict[type[Effect], dict[str, float]], *overrides: str) -> np.ndarray:
    """∮ p dV of both cycles, by the product of the ranges of p and V.

    By the trapezoidal rule: nothing for an elastic finger, which returns through the same points.
    """
    result = run("blocked_force", trial.configured(on, *CYCLES, *overrides), comm=trial.SELF)
    assert result.failure is None
    pressure, volume = result.column("pressure_kPa"), result.column("cavity_volume_mm3")
    cycle = result.column("cycle")
    second = int(np.argmax(cycle == 2))
    parts = (slice(0, second), slice(second - 1, None))  # the second starts where the first ends
    found = [np.trapezoid(pressure[part], volume[part]) for part in parts]
    return np.array(found) / (np.ptp(pressure) * np.ptp(volume))


@pytest.mark.parametrize("overrides", [(), TOUCHING], ids=["free", "touching"])
def test_an_elastic_cycle_takes_nothing(overrides: tuple[str, ...]) -> None:
    assert np.abs(work({}, *overrides)).max() < 1e-7


@pytest.mark.parametrize("effect", DISSIPATIVE, ids=[each.name() for each in DISSIPATIVE])
def test_a_cycle_takes_work(effect: type[Effect]) -> None:
    first, second = work(given(effect), *felt(effect))
    print(f"{effect.name()}: {first:.2e} of p V in the first cycle, {second:.2e} in the second")
    assert first > 1e-5
    if effect.name() in ONCE:
        assert abs(second) < 1e-7
    else:
        assert second > 1e-5


@pytest.mark.parametrize("effect", DISSIPATIVE, ids=[each.name() for each in DISSIPATIVE])
def test_without_a_clock_the_third_cycle_is_the_second(effect: type[Effect]) -> None:
    """Which lets a diagnosis read it there."""
    config = trial.configured(given(effect), *CYCLES, *felt(effect), "experiment.cycles=3")
    result = run("blocked_force", config, comm=trial.SELF)
    assert result.failure is None
    volume, cycle = result.column("cavity_volume_mm3"), result.column("cycle")
    off = np.abs(volume[cycle == 3] - volume[cycle == 2]).max() / np.ptp(volume)
    print(f"{effect.name()}: {off:.1e} of the volume's change")
    assert bool(off > 1e-4) is effect.clock

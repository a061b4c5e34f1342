"""Work that the air does on a finger in a closed cycle: what the dissipative effects take of it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import trial

from dolfingrip.experiments import Result, run
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS

CYCLES = (
    "mesh.size_mm=10",
    "mesh.edge_size_mm=10",
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=10",
    "experiment.cycles=3",
)
TOUCHING = ("finger.gap_mm=0.15", "contact.self_contact=true")
"""Bellows near enough to touch at these pressures, for what acts where they do."""
DISSIPATIVE = [effect for effect in EFFECTS if effect.kind == "dissipative"]
YIELDING = {"yield_strain": 0.005}
"""Below the small strains of this finger."""
SLOW = {"lowest_Hz": 0.01, "highest_Hz": 1.0}
"""A range of frequencies that has that of these cycles."""
ONCE = ("mullins",)
"""What is softened does not soften again up to the same pressure."""
LATER = ("fatigue",)
"""Nothing is tired in the first cycle."""


def given(effect: type[Effect]) -> dict[type[Effect], dict[str, float]]:
    return {
        effect: {"permanent_set": YIELDING, "fatigue": YIELDING, "loss_factor": SLOW}.get(
            effect.name(), {}
        )
    }


def felt(effect: type[Effect]) -> tuple[str, ...]:
    return TOUCHING if effect is BellowsFriction else ()


def cycled(on: dict[type[Effect], dict[str, float]], *overrides: str) -> Result:
    result = run("blocked_force", trial.configured(on, *CYCLES, *overrides), comm=trial.SELF)
    assert result.failure is None
    return result


@cache
def dissipated(effect: type[Effect]) -> Result:
    """Three cycles with an effect, which several tests look at."""
    return cycled(given(effect), *felt(effect))


def work(result: Result) -> np.ndarray:
    """∮ p dV of the first two cycles, by the product of the ranges of p and V.

    By the trapezoidal rule: nothing for an elastic finger, which returns through the same points.
    """
    cycle = result.column("cycle")
    two = cycle <= 2
    pressure, volume = (result.column(name)[two] for name in ("pressure_kPa", "cavity_volume_mm3"))
    second = int(np.argmax(cycle == 2))
    parts = (slice(0, second), slice(second - 1, None))  # the second starts where the first ends
    found = [np.trapezoid(pressure[part], volume[part]) for part in parts]
    return np.array(found) / (np.ptp(pressure) * np.ptp(volume))


@pytest.mark.parametrize("overrides", [(), TOUCHING], ids=["free", "touching"])
def test_an_elastic_cycle_takes_nothing(overrides: tuple[str, ...]) -> None:
    result = cycled({}, *overrides, "experiment.cycles=2")
    assert np.abs(work(result)).max() < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("effect", DISSIPATIVE, ids=[each.name() for each in DISSIPATIVE])
def test_a_cycle_takes_work(effect: type[Effect]) -> None:
    first, second = work(dissipated(effect))
    print(f"{effect.name()}: {first:.2e} of p V in the first cycle, {second:.2e} in the second")
    if effect.name() in LATER:
        assert abs(first) < 1e-7
    else:
        assert first > 1e-5
    if effect.name() in ONCE:
        assert abs(second) < 1e-7
    else:
        assert second > 1e-5


@pytest.mark.parametrize("effect", DISSIPATIVE, ids=[each.name() for each in DISSIPATIVE])
def test_without_a_clock_the_third_cycle_is_the_second(effect: type[Effect]) -> None:
    """Which lets a diagnosis read it there."""
    result = dissipated(effect)
    volume, cycle = result.column("cavity_volume_mm3"), result.column("cycle")
    off = np.abs(volume[cycle == 3] - volume[cycle == 2]).max() / np.ptp(volume)
    print(f"{effect.name()}: {off:.1e} of the volume's change")
    assert bool(off > 1e-4) is effect.clock

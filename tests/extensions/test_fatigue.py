"""Fatigue: moduli and set against the logarithm of cycles, of which some are simulated."""

from __future__ import annotations

import numpy as np
import pytest
from support import bars

from dolfingrip.config import load
from dolfingrip.experiments.protocol import Stop, cycle_at
from dolfingrip.experiments.rigs.uniaxial import Stretching, UniaxialTension
from dolfingrip.sections.tables import assignments

SOFTENING, G, YIELD = 0.04, 0.06, 0.03
TRAVEL_mm = np.array([0.0, 3.0, 6.0, 3.0, 0.0])


def on(softening: float, g: float) -> tuple[str, ...]:
    return (f"extensions.fatigue.softening={softening}", f"extensions.fatigue.g={g}",
            f"extensions.fatigue.yield_strain={YIELD}")  # fmt: skip


def way(*cycles: int) -> tuple[str, ...]:
    """Up and down in each of these cycles."""
    travel = np.tile(TRAVEL_mm, len(cycles))
    numbers = np.repeat(cycles, len(TRAVEL_mm)).tolist()
    return (*bars.protocol(np.arange(travel.size), travel), f"protocol.cycle={numbers}")


def test_moduli_fall_with_the_logarithm_of_cycles() -> None:
    """F(N) = exp(−s log₁₀ N) F(1); of a thousand cycles three are simulated."""
    found = bars.pull(*on(SOFTENING, 0.0), *way(1, 10, 1000)).column("force_N").reshape(3, -1)
    first, *later = found
    assert first.max() > 1
    for decades, forces in zip((1, 3), later, strict=True):
        expected = np.exp(-SOFTENING * decades) * first
        np.testing.assert_allclose(forces, expected, rtol=1e-9, atol=1e-6)


def test_set_is_that_of_a_network_that_grows_with_them() -> None:
    """In the cycle N all readings are those of ``permanent_set`` with g log₁₀ N."""
    found = bars.pull(*on(0.0, G), *way(1000)).column("force_N")
    same = bars.pull(
        f"extensions.permanent_set.g={3 * G}", f"extensions.permanent_set.yield_strain={YIELD}",
        *way(1000),
    ).column("force_N")  # fmt: skip
    assert found[-1] < -0.01  # it has set
    np.testing.assert_allclose(found, same, rtol=0, atol=1e-9)


def test_bars_without_a_mesh_soften_alike() -> None:
    """The way in which a diagnosis pulls coupons, at the same stretch in two cycles."""
    tension = UniaxialTension(load(None, assignments(on(SOFTENING, 0.0))))
    way = Stretching([0.1, 0.2, 0.1, 0.2], [1.0, 2.0, 3.0, 4.0], 0.1, [1, 1, 1000, 1000])
    ((first, later),) = tension.follow({}, [way])[0].stress_MPa[:, [1, 3]]
    assert later == pytest.approx(np.exp(-3 * SOFTENING) * first, rel=1e-9)


def test_between_two_cycles_the_number_grows_with_time() -> None:
    at = cycle_at([Stop(0.0, 0.0, "loading", 1), Stop(1.0, 2.0, "loading", 1),
                   Stop(0.0, 4.0, "unloading", 11)])  # fmt: skip
    assert [at(t) for t in (-1e9, 1.0, 3.0, 9.0)] == pytest.approx([1, 1, 6, 11])

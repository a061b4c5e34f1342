"""What a rigid motion must leave alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support import bodies

SEED = 11
TURN = Rotation.from_rotvec([0.9, -1.4, 0.6]).as_matrix()
SHIFT = np.array([5.0, -3.0, 8.0])


@pytest.fixture(params=["strain", "pressure"])
def deformed(request: pytest.FixtureRequest, hollow: bodies.Body) -> Iterator[bodies.Body]:
    """The hollow cube deformed at random, with one of its energies only."""
    print("seed", SEED)
    kept = [constant.value.copy() for constant in (hollow.mu, hollow.lmbda)]
    if request.param == "pressure":
        hollow.mu.value = hollow.lmbda.value = 0.0
        hollow.pressure.value = 0.2
    hollow.displace(0.08 * np.random.default_rng(SEED).uniform(-1, 1, hollow.nodes.shape))
    yield hollow
    hollow.mu.value, hollow.lmbda.value = kept
    hollow.pressure.value = 0.0
    hollow.displace(np.zeros_like(hollow.nodes))


def test_superposed_rigid_motion(deformed: bodies.Body) -> None:
    """x → Qx + c leaves energy and volume alone and turns all nodal forces by Q.

    A rigid motion is affine, so the elements represent it exactly; the bound is round-off of
    coordinates ten times the body's size.
    """
    energy, forces = deformed.energy(), deformed.gradient()
    moved = (deformed.nodes + deformed.displacement()) @ TURN.T + SHIFT
    deformed.displace(moved - deformed.nodes)
    assert energy != 0.0
    assert deformed.energy() == pytest.approx(energy, rel=1e-11)
    np.testing.assert_allclose(
        deformed.gradient(), forces @ TURN.T, atol=1e-11 * np.abs(forces).max()
    )


def test_no_net_load(deformed: bodies.Body) -> None:
    """Internal forces and a closed cavity's pressure have neither resultant nor moment."""
    forces = deformed.gradient()
    arms = deformed.nodes + deformed.displacement()
    size = np.abs(forces).sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-13 * size)
    np.testing.assert_allclose(np.cross(arms, forces).sum(axis=0), 0, atol=1e-12 * size)

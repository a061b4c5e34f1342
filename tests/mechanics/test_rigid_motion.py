"""What a rigid body remembers from step to step."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from support import bodies

from dolfingrip.mechanics.model.rigid_body import RigidBody, RigidMotion

RATES = np.array([1.0, -2.0, 0.5, 0.2, -0.1, 0.3])
"""Coordinates (mm, rad) for each second."""


def test_a_restored_body_moves_on() -> None:
    """Velocities, too: the next step's potential is what it was."""
    mesh = bodies.box((1, 1, 1))
    body = RigidBody("stone", 0.01, 0.01 * np.diag([1.0, 2.0, 2.5]))
    pose = body.pose(mesh)
    motion = RigidMotion(body, pose, np.array([0.0, 0.0, -9.81]), MPI.COMM_SELF)

    def put(time_s: float, step_s: float) -> float:
        """Potential (mJ) of the step that ends there."""
        for constant, value in zip(pose.constants, time_s * RATES, strict=True):
            constant.value = value
        motion.set_time(time_s, step_s)
        return motion.value(np.empty(0))

    motion.accept()
    put(0.1, 0.1)
    motion.accept()
    kept = motion.values()
    expected = put(0.3, 0.2)
    np.testing.assert_allclose(kept["stone.velocity_mm_per_s"], RATES[:3], rtol=1e-12)
    assert np.abs(kept["stone.turning_per_s"]).max() > 0.1
    put(0.2, 0.1)
    motion.accept()
    put(0.25, 0.05)
    motion.accept()
    assert put(0.3, 0.2) != expected
    motion.restore(kept)
    assert put(0.3, 0.2) == expected
    for name, value in motion.values().items():
        np.testing.assert_array_equal(value, kept[name])

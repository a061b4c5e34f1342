"""A heavy rigid capsule at rest along an elastic slab in plane strain, against Hertz."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import blocks

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.density import TwoStage
from dolfingrip.mechanics.contact.distance import Capsule
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.rigid_body import COORDINATES, RigidBody, RigidMotion
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes.solid import SolidMesh

RADIUS, SIZE, THICK = 10.0, 10.0, 0.3
HALF_WIDTH = 0.04 * RADIUS
"""Of the strip of contact (mm), a twenty-fifth of the slab's size."""
YOUNG, NU = 2.6, 0.3
REDUCED = YOUNG / (1 - NU**2)
CELLS, GRADED = 18, 5.0


def half_slab() -> SolidMesh:
    """The half x ≥ 0 of a slab below z = 0, one layer of elements thick, fine around the line."""
    solid = blocks.block((CELLS, 1, CELLS), (1.0, THICK, 1.0), (0.0, -THICK / 2, -1.0))
    x, y, z = solid.points.T
    points = np.stack([SIZE * _graded(x), y, -SIZE * _graded(-z)], axis=1)
    return replace(solid, points=points)


def _graded(share: np.ndarray) -> np.ndarray:
    return np.asarray(np.sinh(GRADED * share) / np.sinh(GRADED))


def test_the_capsule_presses_as_hertz_says() -> None:
    """p₀ = E* a/(2 R) and W' = π E* a²/(4 R) (Johnson, Contact Mechanics, eq. 4.43 to 4.45).

    The pressure is p₀ √(1 − x²/a²), so ∫p x² dx/∫p dx = a²/4. Its approach has no limit for a half
    space in plane strain, and is not looked at.
    """
    line_load = np.pi * REDUCED * HALF_WIDTH**2 / (4 * RADIUS)
    highest = REDUCED * HALF_WIDTH / (2 * RADIUS)
    held = {0: ["left", "below"], 1: ["front", "back", "below"], 2: ["below"]}
    slab = blocks.Block("slab", half_slab(), blocks.NeoHooke(YOUNG, NU), held=held)
    model = blocks.model([slab], degree=2)
    deepest = HALF_WIDTH**2 / RADIUS
    gravity, width = 9.81, 0.02 * deepest
    body = RigidBody(
        "capsule",
        line_load * THICK / gravity,
        np.eye(3),
        (0.0, 0.0, RADIUS - deepest),
        frozenset(name for name in COORDINATES if name != "z_mm"),
    )
    pose = body.pose(model.domain.mesh)
    pose.constants[3].value = np.pi / 2  # its own axis is z; here it lies along y
    contact = RigidContact(
        model.u, model.domain, ["above"], Capsule(RADIUS, 5.0), pose, TwoStage(width, highest)
    )
    motion = RigidMotion(body, pose, np.array([0, 0, -gravity]), model.comm, copies=2)
    motion.accept()
    model = Model(
        model.domain, model.u, model.potential, model.supports, {}, [motion, contact],
        global_unknowns=pose.free,
    )  # fmt: skip
    nodes = model.u.function_space.tabulate_dof_coordinates()
    below = RADIUS - deepest - np.sqrt(RADIUS**2 - np.minimum(nodes[:, 0], 1.0) ** 2) - width / 2
    guess = np.zeros_like(nodes)
    guess[:, 2] = np.minimum(below, 0.0) * np.exp(nodes[:, 2] / HALF_WIDTH)
    guess[np.isclose(nodes[:, 2], -SIZE)] = 0.0
    model.u.x.array[:] = guess.ravel()
    assert Newton(model, Solver(rtol=1e-8, atol_N=1e-12, max_iterations=80)).solve().converged
    near = contact.near(model.u.x.array)
    assert 2 * contact.load_N(model.u.x.array)[2] == pytest.approx(line_load * THICK, rel=1e-6)
    push, x = np.abs(near.forces).sum(axis=1), near.arms[:, 0]
    half_width = 2 * np.sqrt((push @ x**2) / push.sum())
    # of neighbouring nodes one feels more than the other: the mean over the middle half
    middle = x < HALF_WIDTH / 2
    exact = np.sqrt(1 - (x[middle] / HALF_WIDTH) ** 2)
    pressure = push[middle].sum() / (near.areas[middle] @ exact)
    print(f"p0 off by {pressure / highest - 1:.2e}, a by {half_width / HALF_WIDTH - 1:.2e}")
    assert pressure == pytest.approx(highest, rel=0.03)
    assert half_width == pytest.approx(HALF_WIDTH, rel=0.03)

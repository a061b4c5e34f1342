"""A rigid cube on an inclined table: holds without creep, slides at the limit's excess."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from support import blocks

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.density import Smooth
from dolfingrip.mechanics.contact.distance import Plane
from dolfingrip.mechanics.contact.friction import SLIP_MM, Friction
from dolfingrip.mechanics.contact.rigid_points import RigidPoints
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.pose import Pose
from dolfingrip.mechanics.model.rigid_body import RigidBody, RigidMotion
from dolfingrip.mechanics.newton.newton import Newton

MU, SIDE, MASS_kg, G = 0.4, 33.0, 0.0375, 9.81
EVERY = {axis: ["left"] for axis in range(3)}


class Incline:
    """Gravity is tilted so that tan θ is a share of μ; the block that a model needs is far away."""

    def __init__(self, share: float) -> None:
        far = blocks.block((1, 1, 1), origin=(0, 0, 500))
        block = blocks.Block("far", far, blocks.NeoHooke(2.0, 0.3), held=EVERY)
        model = blocks.model([block])
        inertia = MASS_kg * SIDE**2 / 6 * np.eye(3)
        body = RigidBody("cube", MASS_kg, inertia, (0.0, 0.0, SIDE / 2 + 0.1))
        self.pose = body.pose(model.domain.mesh)
        along = (np.arange(12) + 0.5) / 12 * SIDE - SIDE / 2
        x, y = (grid.ravel() for grid in np.meshgrid(along, along))
        points = np.stack([x, y, np.full_like(x, -SIDE / 2)], axis=1)
        table = Pose([], np.zeros((6, 0)), np.zeros(6))
        contact = RigidPoints(
            model.u, points, np.full(len(points), SIDE**2 / len(points)), self.pose,
            Plane((0.0, 0.0, 1.0)), table, Smooth(0.4, 0.05),
        )  # fmt: skip
        angle = np.arctan(share * MU)
        self.angle = float(angle)
        gravity = G * np.array([0.0, 0.0, -1.0])
        self.motion = RigidMotion(body, self.pose, gravity, model.comm)
        mu = fem.Constant(model.domain.mesh, PETSc.ScalarType(MU))
        self.friction = Friction(contact, model.u, mu)
        self.model = Model(
            model.domain, model.u, model.potential, model.supports, {},
            [self.motion, contact, self.friction], global_unknowns=self.pose.free,
        )  # fmt: skip
        self.motion.accept()
        self.newton = Newton(self.model, Solver(rtol=1e-9, atol_N=1e-12, max_iterations=60))
        self.time_s = 0.0
        for part in np.linspace(0, 0.9, 4):  # the table is tilted slowly
            self.tilt(part)
            self.step(0.2)

    def tilt(self, part: float) -> None:
        """Tilt by a part of the angle."""
        turned = part * self.angle
        self.motion.gravity_m_s2[:] = G * np.array([np.sin(turned), 0, -np.cos(turned)])

    def step(self, step_s: float) -> float:
        """Solve a step; what sliding took (mJ)."""
        self.time_s += step_s
        self.model.prescribe({"time_s": self.time_s})
        solve = self.newton.solve()
        assert solve.converged, solve
        taken = self.friction.dissipated_mJ(self.model.u.x.array)
        self.model.accept_step()
        return taken


def test_it_holds_for_a_minute() -> None:
    """At 0.98 of the limit's slope."""
    cube = Incline(0.98)
    cube.tilt(1.0)
    for _ in range(5):
        cube.step(0.2)
    start = cube.pose.coordinates
    assert abs(start[0]) < 2 * SLIP_MM
    for _ in range(30):
        assert cube.step(2.0) == 0.0
    np.testing.assert_allclose(cube.pose.coordinates, start, atol=1e-9)


def test_it_slides() -> None:
    """At 1.02 of it: with g (sin θ − μ cos θ), and friction takes μ N for each mm."""
    cube = Incline(1.02)
    for _ in range(5):
        cube.step(0.2)
    cube.tilt(1.0)
    rate = 1e3 * G * (np.sin(cube.angle) - MU * np.cos(cube.angle))
    places, taken, step_s = [], [], 0.05
    for _ in range(12):
        taken.append(cube.step(step_s))
        places.append(cube.pose.coordinates[0])
    found = np.diff(places, 2)[2:] / step_s**2
    print("mm/s²", rate, found)
    np.testing.assert_allclose(found, rate, rtol=1e-3)
    assert min(taken) >= 0
    per_mm = MU * MASS_kg * G * np.cos(cube.angle)
    np.testing.assert_allclose(taken[3:], per_mm * np.diff(places)[2:], rtol=0.02)

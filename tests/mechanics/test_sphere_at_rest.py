"""A heavy rigid sphere at rest on an elastic block, against Hertz."""

from __future__ import annotations

import gmsh
import numpy as np
import pytest
from support import blocks

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.density import TwoStage
from dolfingrip.mechanics.contact.distance import Capsule
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.rigid_body import COORDINATES, RigidMotion, ball
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes.gmsh_model import current_mesh, session
from dolfingrip.meshes.groups import SURFACE_TAGS
from dolfingrip.meshes.solid import SolidMesh

RADIUS = 10.0
SPOT = 0.02 * RADIUS
"""Radius of the contact (mm), a fiftieth of the block's size."""
SIZE = 10.0
YOUNG, NU = 2.6, 0.3
REDUCED = YOUNG / (1 - NU**2)
GROUPS = {"clamp": "below", "skin": "above", "tip": "left", "cavity": "front"}
"""Names that a mesh file has, and what they stand for here."""


def quarter_block() -> SolidMesh:
    """The quarter x, y ≥ 0 of a block below z = 0, fine around the contact."""
    sides = {"clamp": (2, -SIZE), "skin": (2, 0.0), "tip": (0, 0.0), "cavity": (1, 0.0)}
    with session("mesh of a block's quarter"):
        gmsh.model.occ.addBox(0, 0, -SIZE, SIZE, SIZE, SIZE)
        gmsh.model.occ.synchronize()
        for name, (axis, level) in sides.items():
            surfaces = [
                surface
                for _, surface in gmsh.model.getEntities(2)
                if abs(gmsh.model.occ.getCenterOfMass(2, surface)[axis] - level) < 1e-6
            ]
            gmsh.model.addPhysicalGroup(2, surfaces, SURFACE_TAGS[name], name)
        field = gmsh.model.mesh.field.add("MathEval")
        far = f"Max(0, Sqrt(x*x + y*y + z*z) - {1.3 * SPOT})"
        gmsh.model.mesh.field.setString(field, "F", f"{0.25 * SPOT} + 0.5 * {far}")
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        mesh = current_mesh()
    return SolidMesh(mesh.points, mesh.cells, {GROUPS[n]: f for n, f in mesh.facets.items()})


def test_the_sphere_sinks_in_as_hertz_says() -> None:
    """F = 4/3 E* √R δ^{3/2} (Johnson, Contact Mechanics, eq. 4.23), F the sphere's weight.

    The sphere's height is solved for. Frictionless, it might slide and turn at no cost: without
    inertia, which test_rigid_contact gives it, these five unknowns have to be held. δ is how deep
    the block's surface goes at the pole. The block is no half space: that stiffens by about half
    a/L, 1 %; mesh and barrier add about as much. The issue allows 3 %.
    """
    deepest = SPOT**2 / RADIUS
    force = 4 / 3 * REDUCED * np.sqrt(RADIUS) * deepest**1.5
    held = {0: ["left", "below"], 1: ["front", "below"], 2: ["below"]}
    material = blocks.NeoHooke(YOUNG, NU)
    block = blocks.Block("block", quarter_block(), material, held=held)
    model = blocks.model([block], degree=2)
    gravity = 9.81
    width = 0.02 * deepest
    sphere = ball(
        "sphere",
        force / gravity,
        RADIUS,
        (0.0, 0.0, RADIUS - deepest),
        held=[name for name in COORDINATES if name != "z_mm"],
    )
    pose = sphere.pose(model.domain.mesh)
    barrier = TwoStage(width, 2 * REDUCED / np.pi * SPOT / RADIUS)  # the pressure under the pole
    contact = RigidContact(model.u, model.domain, ["above"], Capsule(RADIUS, 0.0), pose, barrier)
    motion = RigidMotion(sphere, pose, np.array([0, 0, -gravity]), model.comm, copies=4)
    model = Model(
        model.domain, model.u, model.potential, model.supports, {}, [motion, contact],
        global_unknowns=pose.free,
    )  # fmt: skip
    nodes = model.u.function_space.tabulate_dof_coordinates()
    # as a guess, the block's surface pressed down to half a barrier below the sphere
    away = np.hypot(nodes[:, 0], nodes[:, 1])
    below = RADIUS - deepest - np.sqrt(RADIUS**2 - np.minimum(away, 1.0) ** 2) - width / 2
    guess = np.zeros_like(nodes)
    guess[:, 2] = np.where(np.isclose(nodes[:, 2], 0.0), np.minimum(below, 0.0), 0.0)
    model.u.x.array[:] = guess.ravel()

    assert Newton(model, Solver(rtol=1e-8, atol_N=1e-12, max_iterations=60)).solve().converged
    pole = np.linalg.norm(nodes, axis=1).argmin()
    approach = -model.u.x.array.reshape(-1, 3)[pole, 2]
    print(f"a/R {SPOT / RADIUS} approach {approach:.4e} off by {approach / deepest - 1:.2e}")
    assert 4 * contact.load_N(model.u.x.array)[2] == pytest.approx(force, rel=1e-6)
    assert approach == pytest.approx(deepest, rel=0.02)
    # the sphere rests on the barrier, within its width
    sunk = RADIUS - pose.coordinates[2]
    assert 0 < approach - sunk < width
    assert 4 * model.reactions()[np.isclose(nodes[:, 2], -SIZE), 2].sum() == pytest.approx(
        force, rel=1e-6
    )

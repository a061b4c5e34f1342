"""Several bodies, one of them rigid: any number of ranks find what one found."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from support import blocks, stored

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.density import TwoStage
from dolfingrip.mechanics.contact.distance import Capsule
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.rigid_body import RigidBody, RigidMotion
from dolfingrip.mechanics.newton.newton import Newton


def _dropped(comm: MPI.Comm) -> dict[str, float]:
    """A heavy capsule on two slabs, one upon the other, after some steps in time."""
    held = {axis: ["below"] for axis in range(3)}
    soft, stiff = blocks.NeoHooke(1.0, 0.3), blocks.NeoHooke(3.0, 0.3)
    lower, upper = (blocks.block((4, 4, 2), (2.0, 2.0, 1.0), (0.0, 0.0, z)) for z in (0.0, 1.1))
    slabs = [
        blocks.Block("lower", lower, soft, held=held),
        blocks.Block("upper", upper, stiff, held={0: ["left"], 1: ["front"], 2: ["left"]}),
    ]
    model = blocks.model(slabs, comm=comm)
    domain = model.domain
    surface = Surface(model.u.function_space, domain, domain.facets(*domain.regions))
    inertia = 0.01 * np.diag([1.0, 2.0, 2.5])
    body = RigidBody("stone", 0.01, inertia, (0.9, 1.1, 2.1 + 1.8 + 0.16))
    pose = body.pose(domain.mesh)
    contact = RigidContact(
        model.u, domain, ["upper/above"], Capsule(1.0, 0.8), pose, TwoStage(0.2, 0.5)
    )
    motion = RigidMotion(body, pose, np.array([0.0, 0.0, -9.81]), comm)
    terms = [motion, contact, BarrierContact(surface, 0.1, 2.0)]
    model = Model(
        domain, model.u, model.potential, model.supports, {}, terms, global_unknowns=pose.free
    )
    motion.accept()
    newton = Newton(model, Solver(rtol=1e-11, atol_N=1e-11, max_iterations=80))
    for time_s in (0.002, 0.004, 0.006):
        model.prescribe({"time_s": time_s})
        assert newton.solve().converged
        model.accept_step()
    found = {unknown.name: unknown.value for unknown in pose.free}
    found["load_N"] = float(contact.load_N(model.u.x.array)[2])
    found["energy_mJ"] = model.energy()
    return found


def test_a_stone_on_two_slabs() -> None:
    found = _dropped(MPI.COMM_WORLD)
    assert found["load_N"] > 0.01
    stored.compare("a stone on two slabs", found, rtol=1e-7, atol=1e-9)

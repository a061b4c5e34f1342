"""Two cubes that are pressed together, and friction between them."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from support import bodies
from support.stacks import PUSH, is_upper, stacked

from dolfingrip.mechanics.contact.friction import Friction

SEED = 23
MU = 0.5
SLIP = 1e-3
"""mm; a twentieth of the gap between the cubes."""


def frictional(blocks: bodies.Body, coefficient: float = MU, slip_mm: float = SLIP) -> Friction:
    """Give ``blocks`` friction, from their present state."""
    assert blocks.contact is not None
    mu = fem.Constant(blocks.model.domain.mesh, PETSc.ScalarType(coefficient))
    friction = Friction(blocks.contact, blocks.u, mu, slip_mm)
    blocks.model.terms = [blocks.plate, blocks.contact, friction]
    return friction


def pressed(lower: int, upper: int, turn_rad: float = 0.0) -> bodies.Body:
    """Rigid cubes half a barrier apart, the upper one turned about the middle."""
    blocks = stacked(lower, upper)
    above = is_upper(blocks.nodes)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    arm = blocks.nodes[:, :2] - 0.5
    move = np.column_stack([arm @ [[c, s], [-s, c]] - arm, np.full(len(above), -PUSH)])
    blocks.displace(np.where(above[:, None], move, 0.0))
    return blocks


def on_upper(blocks: bodies.Body, forces: np.ndarray) -> np.ndarray:
    """Sum (3,) over the upper cube of (n, 3) forces at the surface's nodes."""
    assert blocks.contact is not None
    surface = blocks.contact.surface
    return np.asarray(forces[is_upper(surface.rest)].sum(axis=0))


def normal_N(blocks: bodies.Body) -> float:
    """Force between the cubes that the barrier takes."""
    assert blocks.contact is not None
    return -float(on_upper(blocks, blocks.contact.gradient(blocks.u.x.array))[2])


def slid(blocks: bodies.Body, by: np.ndarray) -> np.ndarray:
    """Dofs with the upper cube moved on by (3,) ``by``."""
    return (blocks.displacement() + is_upper(blocks.nodes)[:, None] * by).ravel()


def slips(blocks: bodies.Body) -> list[np.ndarray]:
    """Irregular displacements of both cubes, of about the slip at which friction is full."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    shape = blocks.nodes.shape
    start = blocks.displacement()
    return [(start + SLIP * rng.uniform(-1, 1, shape)).ravel() for _ in range(6)]


def go(blocks: bodies.Body, dofs: np.ndarray, *, update: bool = True) -> None:
    """Accept ``dofs`` as the end of a load step."""
    blocks.u.x.array[:] = dofs
    if update:
        blocks.model.update_lagged()
    blocks.model.accept_step()

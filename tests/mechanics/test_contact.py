"""Barrier contact between two bodies: its derivatives, its balance, its reach."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import basix.ufl
import numpy as np
import pytest
from dolfinx import fem
from support import bodies, taylor

from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.surface import Surface

SEED = 17
WIDTH = 0.1

# a tetrahedron over another: its apex above a face, or its lower edge across an upper edge
BASE = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, -1]]
VERTEX_OVER_FACE = [*BASE, [0.3, 0.25, 0.06], [0.1, 0.1, 1], [0.7, 0.2, 1], [0.2, 0.8, 1]]
EDGE_OVER_EDGE = [
    [-1, 0, 0],
    [1, 0.1, 0.02],
    [0, 0.8, -1],
    [0.1, -0.7, -1],
    [0.1, -1, 0.05],
    [-0.05, 1, 0.07],
    [0.8, 0, 1],
    [-0.8, 0.1, 1],
]
TWO = [[0, 1, 2, 3], [4, 5, 6, 7]]


def everywhere(x: np.ndarray) -> np.ndarray:
    """The whole surface."""
    return np.ones(x.shape[1], dtype=bool)


@pytest.fixture(params=[VERTEX_OVER_FACE, EDGE_OVER_EDGE], ids=["vertex-face", "edge-edge"])
def pair(request: pytest.FixtureRequest, degree: int) -> BarrierContact:
    """Two tetrahedra closer than the barrier's width."""
    solid = bodies.domain(bodies.tetrahedra(np.array(request.param), TWO), {"skin": everywhere})
    element = basix.ufl.element("Lagrange", "tetrahedron", degree, shape=(3,))
    surface = Surface(fem.functionspace(solid.mesh, element), solid, solid.facets("skin"))
    return BarrierContact(surface, WIDTH, 1.0)


def dofs_near_rest(contact: BarrierContact) -> tuple[np.ndarray, np.ndarray]:
    """A small random displacement, and a direction to leave it by."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    size = 3 * (contact.surface.nodes.max() + 1)
    return rng.uniform(-0.005, 0.005, size), rng.uniform(-1, 1, size)


def moved(contact: BarrierContact, by: float) -> np.ndarray:
    """Dofs of the upper body's motion along z (mm)."""
    dofs = np.zeros((contact.surface.nodes.max() + 1, 3))
    dofs[contact.surface.nodes[contact.surface.rest[:, 2] > 0.03], 2] = by
    return dofs.ravel()


def at_vertices(contact: BarrierContact, dofs: np.ndarray) -> np.ndarray:
    """A dof array at the surface's vertices, flattened."""
    return contact.surface.displacement(dofs).ravel()


def line(
    start: np.ndarray, w: np.ndarray, of: Callable[[np.ndarray], Any]
) -> Callable[[float], Any]:
    """``of`` along a line of dofs."""
    return lambda step: of(start + step * w)


def test_gradient(pair: BarrierContact) -> None:
    """The gradient is the value's derivative: the remainder is of second order."""
    start, w = dofs_near_rest(pair)
    slope = float(pair.gradient(start).ravel() @ at_vertices(pair, w))
    assert pair.value(start) > 0.0
    assert abs(slope) > 0.0
    assert taylor.rates(line(start, w, pair.value), slope, 1e-3).min() > 1.9


def test_hessian(pair: BarrierContact) -> None:
    """The Hessian is the gradient's derivative, and symmetric; not projected."""
    start, w = dofs_near_rest(pair)
    hessian = pair.hessian(start)
    assert hessian is not None
    slope = (hessian @ at_vertices(pair, w)).reshape(-1, 3)
    assert taylor.rates(line(start, w, pair.gradient), slope, 1e-3).min() > 1.9
    assert abs(hessian - hessian.T).max() < 1e-12 * abs(hessian).max()
    assert np.linalg.eigvalsh(hessian.toarray()).min() < 0.0


def test_action_is_reaction(pair: BarrierContact) -> None:
    """Contact forces have no resultant and no moment: the potential knows distances only.

    Moments are of the positions that distances are taken between.
    """
    start, _ = dofs_near_rest(pair)
    forces = pair.gradient(start)
    size = np.abs(forces).sum()
    assert size > 0.0
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-13 * size)
    np.testing.assert_allclose(
        np.cross(pair.positions(start), forces).sum(axis=0), 0, atol=1e-12 * size
    )


def test_nothing_beyond_the_width(pair: BarrierContact) -> None:
    """Bodies a little further apart than the width do not know of each other."""
    apart = moved(pair, WIDTH)
    assert pair.value(apart) == 0.0
    assert not pair.gradient(apart).any()
    assert pair.hessian(apart) is None


def test_step_stops_before_the_other_body(pair: BarrierContact) -> None:
    """A step through the other body is cut short before the touch; one away from it is not."""
    rest, step = moved(pair, 0.0), moved(pair, -1.0)
    fraction = pair.max_step(rest, step)
    gap = pair.gap_mm(rest, 1.0)
    assert 0.0 < fraction <= 1.01 * gap
    assert not pair.intersects(fraction * step)
    assert pair.intersects(step)
    assert pair.max_step(rest, -step) == 1.0

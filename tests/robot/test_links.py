"""Links that are cut from a block, and the skin that is bound to them, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from support.bricks import bricks

from dolfingrip.config import Config
from dolfingrip.robot import links

WIDTH, HEIGHT, LENGTH = 12.0, 20.0, 60.0
ENDS = (0.0, 20.0, 30.0, 60.0)
BLOCK = bricks(
    np.linspace(0, WIDTH, 3), np.linspace(-HEIGHT / 2, HEIGHT / 2, 5), np.linspace(0, LENGTH, 13)
)


def test_links_of_a_block_have_mass_and_inertia_of_its_boxes() -> None:
    """m = ρ a b l; I_xx = m (b² + l²)/12 about the middle, and likewise about the other axes."""
    config = Config().changed(material={"density_kg_m3": 1100.0})
    pieces = links.links(BLOCK, config, ENDS)
    assert [(piece.from_mm, piece.to_mm) for piece in pieces] == [(0, 20), (20, 30), (30, 60)]
    for piece in pieces:
        length = piece.to_mm - piece.from_mm
        mass = 1100e-9 * WIDTH * HEIGHT * length
        assert piece.mass_kg == pytest.approx(mass, rel=1e-9)
        middle = (WIDTH / 2, 0.0, (piece.from_mm + piece.to_mm) / 2)
        assert piece.centre_mm == pytest.approx(middle, abs=1e-9)
        a, b, c = WIDTH**2, HEIGHT**2, length**2
        boxed = mass / 12 * np.array([b + c, a + c, a + b])
        # points of a quadrature of degree two and more have the moments of the brick
        np.testing.assert_allclose(piece.inertia_kg_mm2[:3], boxed, rtol=1e-9)
        np.testing.assert_allclose(piece.inertia_kg_mm2[3:], 0.0, atol=1e-9 * boxed.max())
        assert {(x, y) for x, y in piece.section_mm} == {
            (x, y) for x in (0.0, WIDTH) for y in (-HEIGHT / 2, HEIGHT / 2)
        }


def test_a_plane_within_a_brick_parts_its_mass() -> None:
    """A brick of 5 mm, cut at 2 and at 4 mm: each link has points of its own."""
    pieces = links.links(BLOCK, Config(), (0.0, 2.0, 4.0, LENGTH))
    masses = np.array([piece.mass_kg for piece in pieces])
    whole = Config().material.density_kg_m3 * 1e-9 * WIDTH * HEIGHT * LENGTH
    assert masses.sum() == pytest.approx(whole, rel=1e-9)
    np.testing.assert_allclose(masses[:2] / whole, 2 / LENGTH, rtol=0.5)
    assert [piece.centre_mm[2] for piece in pieces] == sorted(p.centre_mm[2] for p in pieces)


def test_the_skin_of_a_block_moves_with_one_or_two_links() -> None:
    skin = links.skin(BLOCK, ENDS)
    z, weights = skin.points_mm[:, 2], skin.weights
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)
    assert ((weights > 0).sum(axis=0) <= 2).all()
    # middles of the links are at 10, 25 and 45 mm: 20 mm is two thirds of the way to the second
    np.testing.assert_allclose(weights[:, z == 20.0].T, [[1 / 3, 2 / 3, 0]] * (z == 20.0).sum())
    assert (weights[0, z <= 10.0] == 1).all()
    assert (weights[2, z >= 45.0] == 1).all()
    corners = skin.points_mm[skin.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    surface = 2 * (WIDTH * HEIGHT + WIDTH * LENGTH + HEIGHT * LENGTH)
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(surface)

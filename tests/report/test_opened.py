"""A whole finger cut open: both sides of its mid plane, and the walls of its chambers."""

from __future__ import annotations

import numpy as np
import pytest
from support import hollow_box

from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.opened import sawn
from dolfingrip.report.skin import Skin, extract_skin


def volume(skin: Skin) -> float:
    a, b, c = (skin.points[skin.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def blocks(widths_mm: list[float]) -> FieldMesh:
    """Hexahedra of 10 mm by 20 mm side by side along y, the first of them from y = 0."""
    across = np.cumsum([0.0, *widths_mm])
    layer = np.array([[0.0, 0], [10, 0], [10, 20], [0, 20]])
    points = np.array([[x, y, z] for y in across for x, z in layer])
    cells = np.arange(8) + 4 * np.arange(len(widths_mm))[:, None]
    return FieldMesh(points - [0, across[-1] / 2, 0], cells, np.arange(len(points)))


@pytest.mark.parametrize("widths_mm", [[4.0, 4.0], [2.0, 4.0, 2.0], [8.0]])
def test_both_sides_have_half_of_it(widths_mm: list[float]) -> None:
    """Also where elements lie across the plane; what is linear stays what it is."""
    mesh = blocks(widths_mm)
    slopes = np.array([[1.0, -2.0, 0.5], [0.0, 3.0, 1.0]])
    first, both = mesh.points @ slopes[0], mesh.points @ slopes.T
    found, (one, two), side = sawn(mesh, [first, both], (1, -1))
    assert one == pytest.approx(found.points @ slopes[0])
    assert two == pytest.approx(found.points @ slopes.T)
    assert (found.points[:, 1] * side).min() >= -1e-6
    skin = extract_skin(found, mirror=False)
    for each in (1.0, -1.0):
        half = skin.part(side[skin.node] == each)
        assert volume(half) == pytest.approx(4 * 10 * 20)
        ends = np.sort(half.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        assert (np.unique(ends, axis=0, return_counts=True)[1] == 2).all()  # closed by its cut


def test_one_side_alone() -> None:
    found, _, side = sawn(blocks([4.0, 4.0]), [])
    assert (side == 1).all()
    assert len(found.cells) == 1
    assert found.points[:, 1].min() == pytest.approx(0.0)


def test_chamber_walls_alone_are_coloured() -> None:
    """All walls of a hollow of 4 mm by 3 mm by 9 mm, and no facet of the cut through them."""
    half = hollow_box.mesh()
    skin = extract_skin(
        FieldMesh(half.points, half.cells, np.arange(len(half.points))), mirror=False
    )
    inside = np.isin(skin.node, half.facets["cavity"])
    found = skin.on_walls(np.where(inside, 5.0, 0.0), 0.0)
    assert set(np.unique(found)) == {0.0, 5.0}
    a, b, c = (skin.points[skin.triangles[found > 0, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert areas.sum() == pytest.approx(2 * 3 * 9 + 2 * 4 * 3 + 4 * 9)

"""Every cell becomes eight: volume, groups and regions stay what they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dolfingrip.config import Mesh
from dolfingrip.meshes.bisection import PARTS, bisected, divided
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.measures import jacobians
from dolfingrip.meshes.solid import MeshError, SolidMesh, second_order
from dolfingrip.meshes.structured import structured_mesh
from dolfingrip.sections.geometry.boxes import CylinderSolid
from dolfingrip.sections.geometry.cast import Cast
from dolfingrip.sections.geometry.round_bellows import RoundBellows

COARSE = Mesh(size_mm=20, edge_size_mm=20)


def _area(mesh: SolidMesh, name: str) -> float:
    """Area of a group of facets that are plane."""
    corners = mesh.points[mesh.facets[name][:, : mesh.shape.facet_corners]]
    across = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    if mesh.shape.facet_corners == 3:
        across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return float(np.linalg.norm(np.cross(*across), axis=1).sum() / 2)


@pytest.mark.parametrize("make", [structured_mesh, finger_mesh])
def test_volume_and_groups_stay(make: Callable[[Cast, Mesh], SolidMesh]) -> None:
    """The parts lie where their numbers say: part i of cell c is row 8 c + i."""
    mesh = make(Cast(), COARSE)
    parts = bisected(mesh)
    assert len(parts.cells) == PARTS * len(mesh.cells)
    assert (jacobians(parts) > 0).all()
    middles, own = (each.points[each.cells].mean(axis=1) for each in (mesh, parts))
    assert own.reshape(-1, PARTS, 3).mean(axis=1) == pytest.approx(middles, abs=0.2)
    assert parts.facets.keys() == mesh.facets.keys()
    for name in mesh.facets:
        assert len(parts.facets[name]) == 4 * len(mesh.facets[name])
        assert _area(parts, name) == pytest.approx(_area(mesh, name))
    for name, rows in mesh.regions.items():
        assert set(parts.regions[name] // PARTS) == set(rows)


def test_new_points_lie_on_round_faces_that_facets_tell() -> None:
    """Wherever the part lies: a twentieth of the chords' distance from their circle is left."""
    geometry = RoundBellows(convolutions=1, wall_mm=2.0)
    mesh, solid = finger_mesh(geometry, Mesh(size_mm=6)), geometry.solid()
    assert isinstance(solid, CylinderSolid)
    crown = solid.cylinders[1]
    turn = Rotation.from_euler("xyz", [0.3, -0.7, 1.1])
    parts = bisected(replace(mesh, points=turn.apply(mesh.points) + 5.0))
    points = turn.inv().apply(parts.points - 5.0)
    assert (jacobians(parts) > 0).all()
    edges = second_order(mesh)  # their middles are chords'
    middles = edges.points[np.unique(edges.facets["skin"])]
    left = []
    for skin in (middles, points[np.unique(parts.facets["skin"])]):
        inward = crown.radius_mm - np.linalg.norm(skin[:, :2] - [crown.axis_mm, 0.0], axis=1)
        low, high = crown.along_mm
        # on the side of the crown, which is no other body's
        side = (skin[:, 2] > low + 1e-6) & (skin[:, 2] < high - 1e-6) & (np.abs(inward) < 1.0)
        left.append(np.abs(inward[side]).max())
    assert left[0] > 0.07
    assert left[1] < 0.05 * left[0]
    assert points[:, 1].min() == pytest.approx(0.0, abs=1e-9)  # the plane of symmetry
    assert np.ptp(points[:, 2]) == pytest.approx(np.ptp(mesh.points[:, 2]), abs=1e-9)


def test_curved_cells_are_refused() -> None:
    with pytest.raises(MeshError, match="order 2; allowed: order 1"):
        bisected(second_order(structured_mesh(Cast(), COARSE)))


def test_cells_are_bisected_as_often_as_asked() -> None:
    mesh = structured_mesh(Cast(), COARSE)
    assert divided(mesh, 1) is mesh
    assert len(divided(mesh, 4).cells) == 64 * len(mesh.cells)
    with pytest.raises(MeshError, match=r"mesh.refine = 3: hexahedra: allowed: 1, 2, 4, 8 or 16"):
        divided(mesh, 3)

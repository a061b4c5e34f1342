"""Every cell becomes eight: volume, groups and regions stay what they are."""

from __future__ import annotations

import numpy as np
import pytest

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


@pytest.mark.parametrize("kind", ["hexahedra", "tetrahedra"])
def test_volume_and_groups_stay(kind: str) -> None:
    """The parts lie where their numbers say: part i of cell c is row 8 c + i."""
    if kind == "hexahedra":
        mesh = structured_mesh(Cast(), COARSE)
    else:
        mesh = finger_mesh(RoundBellows(convolutions=1), Mesh(size_mm=12))
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


def test_round_faces_come_nearer_to_the_circle() -> None:
    """A regular polygon of twice as many sides in a circle: its middles lie on the circle."""
    geometry = RoundBellows(convolutions=1, wall_mm=2.0)
    mesh, solid = finger_mesh(geometry, Mesh(size_mm=8)), geometry.solid()
    assert isinstance(solid, CylinderSolid)
    crown = solid.cylinders[1]
    assert crown.radius_mm == geometry.crown_radius_mm
    radii = []
    for round_faces in ((), (crown,)):
        parts = bisected(mesh, round_faces)
        skin = np.unique(parts.facets["skin"])
        new = parts.points[skin[skin >= len(mesh.points)]]
        off = np.linalg.norm(new[:, :2] - [crown.axis_mm, 0.0], axis=1)
        low, high = crown.along_mm
        # on the side of the crown, which is no other body's
        side = (new[:, 2] > low + 1e-6) & (new[:, 2] < high - 1e-6) & (off > 0.8 * crown.radius_mm)
        radii.append(off[side & (np.abs(off - crown.radius_mm) < 2.0)])
    assert radii[0].min() < crown.radius_mm - 0.05
    assert radii[1] == pytest.approx(crown.radius_mm, abs=1e-9)


def test_curved_cells_are_refused() -> None:
    with pytest.raises(MeshError, match="order 2; allowed: order 1"):
        bisected(second_order(structured_mesh(Cast(), COARSE)))


def test_cells_are_bisected_as_often_as_asked() -> None:
    mesh = structured_mesh(Cast(), COARSE)
    assert divided(mesh, 1) is mesh
    assert len(divided(mesh, 4).cells) == 64 * len(mesh.cells)
    with pytest.raises(MeshError, match=r"mesh.refine = 3: hexahedra: allowed: 1, 2, 4, 8 or 16"):
        divided(mesh, 3)

"""The surface: closed, outward, mirrored, and cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import synthetic_run

from dolfingrip.meshes import measures
from dolfingrip.meshes.cells import BY_NODES, HEXAHEDRON, TETRAHEDRON
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.report.fields import FieldMesh, list_steps, read_grid, read_mesh
from dolfingrip.report.skin import Skin, extract_skin


@pytest.fixture
def half(run: Path) -> FieldMesh:
    return read_mesh(read_grid(list_steps(run / "fields.pvd")[0]))


def _volume(skin: Skin) -> float:
    a, b, c = (skin.points[skin.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_mirrored_surface_is_closed_and_outward(half: FieldMesh) -> None:
    skin = extract_skin(half)
    shape = BY_NODES[4 if half.cells.shape[1] in (4, 10) else 8]
    corners = half.cells[:, : shape.corners]
    measure = measures.jacobians(SolidMesh(half.points, corners, {})).mean(axis=1)
    solid = np.abs(measure).sum() / (6 if shape is TETRAHEDRON else 1)
    assert _volume(skin) == pytest.approx(2 * solid, rel=1e-9)
    ends = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(ends, axis=0, return_counts=True)[1] == 2).all()


def test_mirror_image_moves_the_other_way_across(half: FieldMesh) -> None:
    skin = extract_skin(half)
    sideways = np.zeros_like(half.points)
    sideways[:, 1] = half.points[:, 1]
    moved = skin.move(sideways)
    np.testing.assert_allclose(moved[:, 1], 2 * skin.points[:, 1])
    assert moved[:, 1].min() == pytest.approx(-synthetic_run.WIDTH_MM)


def test_half_can_be_left_half(half: FieldMesh) -> None:
    skin = extract_skin(half, mirror=False)
    assert skin.points[:, 1].min() >= -1e-9
    assert 2 * _volume(skin) == pytest.approx(_volume(extract_skin(half)))  # closed by its cut


def test_whole_finger_is_not_mirrored_again(half: FieldMesh) -> None:
    shifted = half.points - [0.0, synthetic_run.WIDTH_MM / 4, 0.0]
    whole = FieldMesh(shifted, half.cells, half.source)
    assert (extract_skin(whole).side == 1).all()
    with pytest.raises(ValueError, match="half finger only"):
        extract_skin(whole, cut=True)


def test_section_lies_in_the_symmetry_plane(half: FieldMesh) -> None:
    section = extract_skin(half, cut=True)
    assert np.abs(section.points[:, 1]).max() < 1e-9
    assert section.triangles.size > 0


def test_creases_are_the_folds_of_the_reference_pose(half: FieldMesh) -> None:
    skin = extract_skin(half)
    folds = set(map(tuple, np.sort(skin.creases, axis=1)))
    edges = set(map(tuple, np.sort(skin.edges, axis=1)))
    assert folds < edges
    back = skin.points[skin.creases][:, :, 0] < 1e-9  # on the flat back only its rim folds
    on_back = skin.points[skin.creases][back.all(axis=1)]
    rim = (
        (np.abs(np.abs(on_back[..., 1]) - synthetic_run.WIDTH_MM / 2) < 1e-9)
        | (on_back[..., 2] < 1e-9)
        | (on_back[..., 2] > synthetic_run.LENGTH_MM - 1e-9)
    )
    assert rim.all()


@pytest.mark.parametrize(("nodes", "triangles"), [(8, 12), (20, 36)])
def test_skin_of_one_brick(nodes: int, triangles: int) -> None:
    """Closed and outward for both handednesses, each quadrilateral cut into its triangles."""
    corners = HEXAHEDRON.reference - [0.0, 0.5, 0.0]
    points = np.concatenate([corners, corners[HEXAHEDRON.edges].mean(axis=1)])[:nodes]
    for sign in (1.0, -1.0):
        brick = FieldMesh(points * [sign, 1, 1], np.arange(nodes)[None], np.arange(nodes))
        skin = extract_skin(brick)
        assert len(skin.triangles) == triangles
        assert _volume(skin) == pytest.approx(1)
        assert len(skin.creases) == len(skin.edges) == 12 * (1 if nodes == 8 else 2)

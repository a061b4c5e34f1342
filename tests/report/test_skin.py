"""The surface: closed, outward, mirrored, and cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from report import synthetic

from dolfingrip.report.fields import Tetrahedra, list_steps, read_grid, read_tetrahedra
from dolfingrip.report.skin import Skin, extract_skin


@pytest.fixture
def half(run: Path) -> Tetrahedra:
    return read_tetrahedra(read_grid(list_steps(run / "fields.pvd")[0]))


def _volume(skin: Skin) -> float:
    a, b, c = (skin.points[skin.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_mirrored_surface_is_closed_and_outward(half: Tetrahedra) -> None:
    skin = extract_skin(half)
    a, b, c, d = (half.points[half.cells[:, i]] for i in range(4))
    solid = np.abs(np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a))).sum() / 6
    assert _volume(skin) == pytest.approx(2 * solid, rel=1e-9)
    ends = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(ends, axis=0, return_counts=True)[1] == 2).all()


def test_mirror_image_moves_the_other_way_across(half: Tetrahedra) -> None:
    skin = extract_skin(half)
    sideways = np.zeros_like(half.points)
    sideways[:, 1] = half.points[:, 1]
    moved = skin.move(sideways)
    np.testing.assert_allclose(moved[:, 1], 2 * skin.points[:, 1])
    assert moved[:, 1].min() == pytest.approx(-synthetic.WIDTH_MM)


def test_half_can_be_left_half(half: Tetrahedra) -> None:
    skin = extract_skin(half, mirror=False)
    assert skin.points[:, 1].min() >= -1e-9
    assert 2 * _volume(skin) == pytest.approx(_volume(extract_skin(half)))  # closed by its cut


def test_whole_finger_is_not_mirrored_again(half: Tetrahedra) -> None:
    shifted = half.points - [0.0, synthetic.WIDTH_MM / 4, 0.0]
    whole = Tetrahedra(shifted, half.cells, half.source)
    assert (extract_skin(whole).side == 1).all()
    with pytest.raises(ValueError, match="half finger only"):
        extract_skin(whole, cut=True)


def test_section_lies_in_the_symmetry_plane(half: Tetrahedra) -> None:
    section = extract_skin(half, cut=True)
    assert np.abs(section.points[:, 1]).max() < 1e-9
    assert section.triangles.size > 0


def test_creases_are_the_folds_of_the_reference_pose(half: Tetrahedra) -> None:
    skin = extract_skin(half)
    folds = set(map(tuple, np.sort(skin.creases, axis=1)))
    edges = set(map(tuple, np.sort(skin.edges, axis=1)))
    assert folds < edges
    back = skin.points[skin.creases][:, :, 0] < 1e-9  # on the flat back only its rim folds
    on_back = skin.points[skin.creases][back.all(axis=1)]
    rim = (
        (np.abs(np.abs(on_back[..., 1]) - synthetic.WIDTH_MM / 2) < 1e-9)
        | (on_back[..., 2] < 1e-9)
        | (on_back[..., 2] > synthetic.LENGTH_MM - 1e-9)
    )
    assert rim.all()

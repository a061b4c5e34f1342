"""The mesh morph: closed forms, its inverse, both orders, and what it refuses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.meshes import files
from dolfingrip.meshes.measures import centroid, enclosed_volume, jacobians
from dolfingrip.meshes.morph import MorphMap, morphed
from dolfingrip.meshes.solid import MeshError, SolidMesh

CORNERS = [(-0.2, -0.5), (-0.2, 1.0), (1.0, -0.5), (1.0, 1.0), (0.306, -0.298)]
D = 9.5
PLANES = {"half": D, "half_second_order": D, "bricks": 3.1, "bricks_second_order": 3.1}
"""The plane between the regions (mm) in each mesh; within elements in all of them."""
MESHES = list(PLANES)


def volume(mesh: SolidMesh) -> float:
    return sum(enclosed_volume(mesh.points, facets) for facets in mesh.facets.values())


def closed_form(morph: MorphMap) -> tuple[float, float]:
    """Volume (mm³) of the half finger's solid and of its cavity, from the boxes it is made of."""
    finger = Config().finger
    width = finger.width_mm / 2
    inner = width - finger.wall_mm
    roof = finger.base_layer_mm + finger.channel_mm

    def box(x0: float, x1: float, y: float, z: float) -> float:
        return float(morph.moved(np.array(x1)) - morph.moved(np.array(x0))) * y * z

    chamber = finger.bellows_mm - 2 * finger.wall_mm
    run = (finger.bellows - 1) * finger.pitch_mm + chamber
    top = finger.depth_mm - finger.wall_mm
    cavity = box(finger.base_layer_mm, roof, inner, run)
    cavity += finger.bellows * box(roof, top, inner, chamber)
    gaps = sum(
        box(roof + finger.wall_mm, finger.depth_mm, width, end - start)
        for start, end in finger.gap_intervals()
    )
    body = box(0, finger.depth_mm, width, finger.length_mm)
    return body - gaps - cavity, cavity


@pytest.mark.parametrize(("xi1", "xi2"), CORNERS)
def test_volumes_are_those_of_the_moved_boxes(half: SolidMesh, xi1: float, xi2: float) -> None:
    """Elements that straddle x = d change nothing: the boundary's planes stay planes."""
    morph = MorphMap(xi1, xi2, D)
    moved = morphed(half, morph)
    solid, cavity = closed_form(morph)
    assert volume(moved) == pytest.approx(solid, rel=1e-12)
    assert -enclosed_volume(moved.points, moved.facets["cavity"]) == pytest.approx(
        cavity, rel=1e-12
    )


@pytest.mark.parametrize(("xi1", "xi2"), CORNERS)
@pytest.mark.parametrize("name", MESHES)
def test_inverse_restores_the_original(
    name: str, xi1: float, xi2: float, request: pytest.FixtureRequest
) -> None:
    mesh = request.getfixturevalue(name)
    if mesh.order == 2:
        mesh = curved(mesh)
    morph = MorphMap(xi1, xi2, PLANES[name])
    back = morphed(morphed(mesh, morph), morph.inverse())
    assert np.abs(back.points - mesh.points).max() < 2e-14 * 90


def curved(mesh: SolidMesh) -> SolidMesh:
    """A second-order mesh with bent edges."""
    points = mesh.points.copy()
    middles = np.unique(mesh.cells[:, mesh.shape.corners :])
    seed = 5
    print(f"seed {seed}")
    points[middles] += np.random.default_rng(seed).uniform(-0.01, 0.01, (len(middles), 3))
    return replace(mesh, points=points)


@pytest.mark.parametrize("name", ["half_second_order", "bricks_second_order"])
def test_straight_edges_stay_straight(name: str, request: pytest.FixtureRequest) -> None:
    mesh = request.getfixturevalue(name)
    moved = morphed(mesh, MorphMap(1.0, -0.5, PLANES[name]))
    ends = moved.points[moved.cells[:, mesh.shape.edges]].mean(axis=2)
    assert np.abs(ends - moved.points[moved.cells[:, mesh.shape.corners :]]).max() < 1e-13
    assert jacobians(moved).min() > 0


def test_centre_of_gravity_of_the_published_designs() -> None:
    """COG offsets 2.5, 3.0 and 3.5 mm of the paper's optima; the original lies between two."""
    config = Config()
    from dolfingrip.meshes.generate import finger_mesh

    original = finger_mesh(config.finger, config.mesh)
    offsets = {(0.236, -0.363): 2.5, (0.306, -0.298): 3.0, (0.374, -0.229): 3.5}
    for (xi1, xi2), offset in offsets.items():
        moved = morphed(original, MorphMap(xi1, xi2, config.morph.d_mm))
        assert centroid(moved)[0] - config.cog.x_ref_mm == pytest.approx(offset, abs=0.03)
    assert 2.5 < centroid(original)[0] - config.cog.x_ref_mm < 3.0


@pytest.mark.parametrize("xi1", np.linspace(-0.2, 1, 4))
@pytest.mark.parametrize("xi2", np.linspace(-0.5, 1, 4))
def test_no_element_is_inverted_within_the_bounds(
    half_second_order: SolidMesh, xi1: float, xi2: float
) -> None:
    morphed(half_second_order, MorphMap(xi1, xi2, D))


def test_inverted_elements_name_xi(half: SolidMesh) -> None:
    # a flat tetrahedron across x = 1: its edge 01 bends through edge 23 as the slopes differ
    points = np.array([[0.0, 0, 0], [2, 2, 0], [0.9, 1, 0.9], [0.9, 1, -1]])
    sliver = SolidMesh(points, np.array([[0, 1, 2, 3]]), {})
    if jacobians(sliver).min() < 0:
        sliver = SolidMesh(points, np.array([[0, 1, 3, 2]]), {})
    morphed(sliver, MorphMap(0.05, 0.05, 1.0))
    with pytest.raises(MeshError, match=r"xi1 = 1, xi2 = -0\.5: turns 1 of 1 elements inside out"):
        morphed(sliver, MorphMap(1.0, -0.5, 1.0))
    with pytest.raises(MeshError, match=r"xi1 = -1\.5, xi2 = 0: turns .* elements inside out"):
        morphed(half, MorphMap(-1.5, 0.0, D))
    with pytest.raises(MeshError, match="xi1 = -1, xi2 = 0: cannot be undone"):
        MorphMap(-1.0, 0.0, D).inverse()


@pytest.mark.parametrize("suffix", [".vtk", ".vtu"])
@pytest.mark.parametrize("name", MESHES)
def test_vtk_is_read_back(
    name: str, suffix: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    mesh = request.getfixturevalue(name)
    files.write(tmp_path / f"finger{suffix}", mesh)
    found = files.read(tmp_path / f"finger{suffix}")
    np.testing.assert_allclose(found.points, mesh.points)
    np.testing.assert_array_equal(found.cells, mesh.cells)
    assert {name: len(f) for name, f in found.facets.items()} == {
        name: len(f) for name, f in mesh.facets.items()
    }

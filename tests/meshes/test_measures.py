"""Volumes and centroids of straight elements and the quadrature behind them, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dolfingrip.meshes import measures
from dolfingrip.meshes.cells import HEXAHEDRON, TETRAHEDRON, CellShape
from dolfingrip.meshes.solid import SolidMesh, boundary, faces, mirrored, second_order


def closed(points: list[tuple[float, float, float]], cells: list[list[int]]) -> SolidMesh:
    """A mesh with its whole surface as one group."""
    elements = np.array(cells)
    surface = faces(elements)[boundary(elements)]
    return SolidMesh(np.array(points, dtype=float), elements, {"all": surface})


def tetrahedra() -> SolidMesh:
    """Two that share a face, of 4 and 8 mm³; each centroid is the mean of the corners.

    So that of both is (4 (1/2, 3/4, 1) + 8 (1, 3/2, 2)) / 12.
    """
    points = [(0, 0, 0), (2, 0, 0), (0, 3, 0), (0, 0, 4), (2, 3, 4)]
    return closed(points, [[0, 1, 2, 3], [1, 2, 3, 4]])


def frustum() -> SolidMesh:
    """A hexahedron from a square of side 2 at z = 0 to one of side 1 at z = 3.

    With the side s = 2 − z / 3 the volume is ∫ s² dz = 7, and the moments are ∫ s³ / 2 dz = 45/8
    in x and y and ∫ z s² dz = 33/4 in z.
    """
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    points = [(2.0 * x, 2.0 * y, 0.0) for x, y in corners] + [(x, y, 3.0) for x, y in corners]
    return closed(points, [list(range(8))])


EXACT = [
    pytest.param(tetrahedra(), 12, (5 / 6, 5 / 4, 5 / 3), id="tetrahedra"),
    pytest.param(frustum(), 7, (45 / 56, 45 / 56, 33 / 28), id="frustum"),
]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("mesh", "volume_mm3", "centroid_mm"), EXACT)
def test_volume_and_centroid(
    mesh: SolidMesh, volume_mm3: float, centroid_mm: tuple[float, ...], order: int
) -> None:
    if order == 2:
        mesh = second_order(mesh)
    assert measures.enclosed_volume(mesh.points, mesh.facets["all"]) == pytest.approx(volume_mm3)
    assert measures.centroid(mesh) == pytest.approx(centroid_mm)


def test_jacobians_of_tetrahedra_are_six_times_the_volume() -> None:
    assert measures.jacobians(tetrahedra())[:, 0] == pytest.approx([24, 48])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("mesh", [tetrahedra(), frustum()], ids=["tetrahedra", "frustum"])
def test_half_a_solid_and_its_mirror_image_are_one_body(mesh: SolidMesh, order: int) -> None:
    """Twice the volume, its centroid in the plane, and the nodes of the plane once."""
    if order == 2:
        mesh = second_order(mesh)
    every = faces(mesh.cells)[boundary(mesh.cells)]
    in_plane = (mesh.points[every, 1] == 0).all(axis=1)
    half = replace(
        mesh, facets={"all": every[~in_plane], "symmetry": every[in_plane]},
        regions={"first": np.array([0])},
    )  # fmt: skip
    whole = mirrored(half)
    assert (measures.jacobians(whole) > 0).all()
    twice = 2 * measures.enclosed_volume(mesh.points, every)
    assert measures.enclosed_volume(whole.points, whole.facets["all"]) == pytest.approx(twice)
    x, _, z = measures.centroid(mesh)
    assert measures.centroid(whole) == pytest.approx((x, 0, z))
    shared = len(np.unique(every[in_plane]))
    assert len(whole.points) == 2 * len(mesh.points) - shared
    assert whole.regions["first"].tolist() == [0, len(mesh.cells)]
    assert list(whole.facets) == ["all"]


def centroid_rate(mesh: SolidMesh, velocity: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("cni,ni->c", measures.centroid_gradients(mesh), velocity))


def test_centroid_rate_as_one_corner_moves() -> None:
    """The last corner moves by 1 along x: 12 ċ = d(moment) − 2 c, as the volume grows by 2.

    The moment's rate is that of the second tetrahedron, 2 (1, 3/2, 2) + 8 (1/4, 0, 0).
    """
    mesh = tetrahedra()
    velocity = np.zeros_like(mesh.points)
    velocity[4, 0] = 1
    assert centroid_rate(mesh, velocity) == pytest.approx((7 / 36, 1 / 24, 1 / 18))


@pytest.mark.parametrize("mesh", [tetrahedra(), frustum()])
def test_centroid_rate_as_all_move(mesh: SolidMesh) -> None:
    shift = np.broadcast_to([1.0, -2.0, 0.5], mesh.points.shape)
    assert centroid_rate(mesh, shift) == pytest.approx(shift[0])
    grown = replace(mesh, points=3 * mesh.points)
    assert measures.centroid(grown) == pytest.approx(3 * measures.centroid(mesh))
    assert centroid_rate(mesh, mesh.points) == pytest.approx(measures.centroid(mesh))


@pytest.mark.parametrize(
    ("shape", "volume", "moment"), [(TETRAHEDRON, 1 / 6, 1 / 24), (HEXAHEDRON, 1, 1 / 2)]
)
def test_quadrature_of_the_reference_cells(shape: CellShape, volume: float, moment: float) -> None:
    """A centroid says nothing of the weights' sum, which cancels in it: so it is held here."""
    at, weights = measures.CELL_QUADRATURE[shape]
    assert weights.sum() == pytest.approx(volume, rel=1e-14)
    assert weights @ at == pytest.approx(np.full(3, moment), rel=1e-14)


@pytest.mark.parametrize(("corners", "area", "moment"), [(3, 1 / 2, 1 / 6), (4, 1, 1 / 2)])
def test_quadrature_of_the_reference_facets(corners: int, area: float, moment: float) -> None:
    at, weights = measures.FACET_QUADRATURE[corners]
    assert weights.sum() == pytest.approx(area, rel=1e-13)
    assert weights @ at == pytest.approx(np.full(2, moment), rel=1e-13)

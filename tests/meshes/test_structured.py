"""The finger's grid of hexahedra against its dimensions and Gmsh's mesh of the same boxes."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.config import Finger, Mesh
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.measures import centroid
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError
from dolfingrip.meshes.structured import grid, structured_mesh
from dolfingrip.sections.geometry.cast import Cast

FINGERS = {
    "reference": {},
    "narrow channel": {"channel_width_mm": 8.0, "gap_mm": 1.35, "base_block_mm": 28.0},
    "high channel": {"channel_mm": 9.0},
    "thin walls": {"wall_mm": 0.6, "bellows": 3},
}  # fmt: skip


@pytest.mark.parametrize("half", [True, False])
@pytest.mark.parametrize("finger", FINGERS)
def test_fills_the_same_space_as_tetrahedra(finger: str, half: bool) -> None:
    dimensions = Finger.model_validate(FINGERS[finger])
    ours = structured_mesh(dimensions, Mesh(half=half))
    other = finger_mesh(dimensions, Mesh(half=half, size_mm=10))
    found, expected = check(ours), check(other)
    assert found.volume_mm3 == pytest.approx(expected.volume_mm3, rel=1e-12)
    assert found.cavity_mm3 == pytest.approx(expected.cavity_mm3, rel=1e-12)
    np.testing.assert_allclose(centroid(ours), centroid(other), atol=1e-10)
    assert set(ours.facets) == set(other.facets)


def test_grading_and_refinement() -> None:
    """At concave edges cells of the asked size on the hollow side; each divided by ``refine``."""
    edge = 0.4
    graded = grid(Finger(), Mesh(edge_size_mm=edge))
    x, y, z = graded.planes
    valley, floor, side = 7.6, 3.5, 8.4
    gap, chamber = Finger().gap_intervals()[0], Finger().solid().cavity[1][2]
    for plane, value, hollow in (
        (x, valley, 1),
        (x, floor, 1),
        (y, side, -1),
        (z, gap[0], 1),
        (z, gap[1], -1),
        (z, chamber[0], 1),
        (z, chamber[1], -1),
    ):
        at = int(np.abs(plane - value).argmin())
        assert plane[at] == pytest.approx(value, abs=1e-12)
        assert abs(plane[at + hollow] - plane[at]) == pytest.approx(edge, rel=1e-9)
    twice = grid(Finger(), Mesh(edge_size_mm=edge, refine=2))
    for coarse, fine in zip(graded.planes, twice.planes, strict=True):
        np.testing.assert_allclose(fine[::2], coarse, atol=1e-12)


def test_an_eighth_of_the_wall_at_edges() -> None:
    thick = Finger(wall_mm=2.0)
    for default, told in zip(
        grid(thick, Mesh()).planes, grid(thick, Mesh(edge_size_mm=0.25)).planes, strict=True
    ):
        np.testing.assert_array_equal(default, told)


def test_largest_cell() -> None:
    for planes in grid(Finger(), Mesh(size_mm=3.0)).planes:
        assert np.diff(planes).max() <= 3.0 + 1e-12
    # cells that grow from the ends of a long chamber grow up to that size, too
    long = Cast(chambers=1, chamber_length_mm=72.0)
    for planes in grid(long, Mesh(size_mm=4.0, edge_size_mm=0.5)).planes:
        assert np.diff(planes).max() <= 4.0 + 1e-12


def test_too_many_cells_are_refused() -> None:
    with pytest.raises(MeshError, match=r"^mesh\.size_mm = 0\.01: about .* hexahedra; allowed: "):
        structured_mesh(Finger(), Mesh(size_mm=0.01))

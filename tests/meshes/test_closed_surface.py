"""Closed surfaces: volume, inertia, distances, STL files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

from dolfingrip.foods.potato import potato
from dolfingrip.meshes import closed_surface
from dolfingrip.meshes.closed_surface import ClosedSurface, level_set
from dolfingrip.meshes.solid import MeshError

BOX = np.array([1.0, 2.0, 4.0])


def box(at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> ClosedSurface:
    solid = pv.Cube(center=at, x_length=BOX[0], y_length=BOX[1], z_length=BOX[2])
    solid = solid.triangulate().clean()
    return ClosedSurface(np.asarray(solid.points, float), np.asarray(solid.regular_faces))


def test_a_box() -> None:
    """V, centre and I = m/12 (b² + c²) exactly, wherever it is."""
    found = box((3.0, -1.0, 2.0))
    volume = BOX.prod()
    assert found.volume_mm3 == pytest.approx(volume, rel=1e-6)
    np.testing.assert_allclose(found.centre_mm, [3, -1, 2], rtol=1e-6)
    wanted = volume / 12 * np.diag((BOX**2).sum() - BOX**2)
    np.testing.assert_allclose(found.inertia_mm5(), wanted, atol=1e-5)
    assert found.point_areas_mm2().sum() == pytest.approx(2 * (2 + 4 + 8), rel=1e-6)


def test_distances() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 2.0, 0.0]])
    np.testing.assert_allclose(box().distances_mm(points), [-0.5, 1.5, np.sqrt(2)], rtol=1e-6)


def test_a_sphere_cut_from_its_distance() -> None:
    """Of second order in the spacing: 4/3 π r³ and 2/5 m r²."""

    def distance(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        length = np.linalg.norm(x, axis=1)
        return length - 3, x / np.maximum(length, 1e-12)[:, None]

    found = level_set(distance, np.full(3, -3.5), np.full(3, 3.5), 0.3)
    np.testing.assert_allclose(np.linalg.norm(found.points, axis=1), 3, rtol=1e-12)
    volume = 4 / 3 * np.pi * 27
    assert found.volume_mm3 == pytest.approx(volume, rel=7e-3)
    np.testing.assert_allclose(
        found.inertia_mm5(), 0.4 * found.volume_mm3 * 9 * np.eye(3), rtol=1e-2, atol=1e-2
    )


def test_potatoes_differ_by_their_seed_alone() -> None:
    one, same, other = (potato((50.0, 60.0, 40.0), 2.0, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.points, same.points)
    assert np.abs(one.points - other.points).max() > 0.5
    smooth = potato((50.0, 60.0, 40.0), 1e-9, 3)
    assert smooth.volume_mm3 == pytest.approx(np.pi / 6 * 50 * 60 * 40, rel=5e-3)
    assert one.polydata().is_manifold  # type: ignore[attr-defined]
    assert np.abs(one.centre_mm).max() < 1e-9


def test_stl_files(tmp_path: Path) -> None:
    whole = tmp_path / "box.stl"
    box().polydata().save(whole)  # type: ignore[attr-defined]
    found = closed_surface.read(whole)
    assert found.volume_mm3 == pytest.approx(BOX.prod(), rel=1e-6)
    inward = ClosedSurface(found.points, found.triangles[:, ::-1])
    inward.polydata().save(whole)  # type: ignore[attr-defined]
    assert closed_surface.read(whole).volume_mm3 == pytest.approx(BOX.prod(), rel=1e-6)
    opened = ClosedSurface(found.points, found.triangles[1:])
    opened.polydata().save(whole)  # type: ignore[attr-defined]
    with pytest.raises(MeshError, match="allowed: a closed surface of triangles"):
        closed_surface.read(whole)
    with pytest.raises(MeshError, match=r"food\.file = .*none\.stl: no such file"):
        closed_surface.read(tmp_path / "none.stl")

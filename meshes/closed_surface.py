"""Closed triangulated surfaces: enclosed volume, inertia, distance of points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.meshes import vtk_file
from dolfingrip.meshes.solid import Floats, Ints, MeshError

MM3_PER_M3: Final = 1e9

PROJECTIONS: Final = 4
"""Newton's steps that move a point onto a surface from half a cell away or less."""


@dataclass(frozen=True, slots=True)
class ClosedSurface:
    """Triangles that enclose a solid.

    Attributes:
        points: (n, 3) in mm.
        triangles: (m, 3) corners, counter-clockwise seen from outside.
    """

    points: Floats
    triangles: Ints

    @property
    def volume_mm3(self) -> float:
        """Enclosed volume, ⅓ ∮ x · n dA."""
        return float(self._tetrahedra().sum())

    @property
    def centre_mm(self) -> Floats:
        """Centre of the enclosed volume, (3,)."""
        volumes = self._tetrahedra()
        means = self.points[self.triangles].sum(axis=1) / 4
        return np.asarray(volumes @ means / volumes.sum())

    def inertia_mm5(self) -> Floats:
        """Tensor about the centre of the enclosed volume at density 1, (3, 3).

        ∫ x xᵀ dV over each tetrahedron from the centre to a triangle is V/20 (Σ p pᵀ + s sᵀ), s
        the sum of its corners p.
        """
        about = self.moved(-self.centre_mm)
        corners = about.points[about.triangles]
        total = corners.sum(axis=1)
        volumes = about._tetrahedra() / 20
        second = np.einsum("n,nai,naj->ij", volumes, corners, corners)
        second += np.einsum("n,ni,nj->ij", volumes, total, total)
        return np.asarray(np.trace(second) * np.eye(3) - second)

    def point_areas_mm2(self) -> Floats:
        """Area (mm²) that belongs to each point, (n,)."""
        corners = self.points[self.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        third = np.repeat(np.linalg.norm(normal, axis=1) / 6, 3)
        return np.asarray(np.bincount(self.triangles.ravel(), third, len(self.points)), dtype=float)

    def moved(self, by_mm: Floats) -> ClosedSurface:
        """The surface moved by a translation."""
        return ClosedSurface(self.points + by_mm, self.triangles)

    def turned(self, turn: Floats) -> ClosedSurface:
        """The surface turned about the origin by a (3, 3) rotation."""
        return ClosedSurface(self.points @ turn.T, self.triangles)

    def distances_mm(self, points: Floats) -> Floats:
        """Signed distances of points, positive outside, (k,)."""
        import pyvista as pv

        measured = pv.PolyData(np.array(points)).compute_implicit_distance(self.polydata())
        return np.array(measured["implicit_distance"])

    def polydata(self) -> Any:
        """The surface as a PyVista mesh."""
        import pyvista as pv

        return pv.PolyData(self.points, faces=np.insert(self.triangles, 0, 3, axis=1).ravel())

    def _tetrahedra(self) -> Floats:
        """Signed volumes of the tetrahedra between the origin and each triangle, (m,)."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)


def read(path: Path, key: str = "food.file") -> ClosedSurface:
    """Read a closed surface from an STL file in mm.

    Args:
        path: the STL file.
        key: key of the configuration for the error.

    Returns:
        The surface (mm).

    Raises:
        MeshError: one line, if the file cannot be read, or its surface is open or encloses nothing.
    """
    if not path.is_file():
        raise MeshError(f"{key} = {path}: no such file")
    if path.suffix.lower() != ".stl":
        raise MeshError(f"{key} = {path}: allowed: an .stl file")
    read = vtk_file.read(path)
    solid = read.triangulate().clean() if read.n_points else read
    if not solid.n_points or not solid.is_manifold or solid.n_open_edges:
        raise MeshError(f"{key} = {path}: allowed: a closed surface of triangles")
    triangles = np.asarray(solid.regular_faces, dtype=np.int64)
    surface = ClosedSurface(np.asarray(solid.points, dtype=float), triangles)
    if surface.volume_mm3 < 0:
        surface = ClosedSurface(surface.points, triangles[:, ::-1].copy())
    if surface.volume_mm3 <= 0:
        raise MeshError(f"{key} = {path}: encloses no volume; allowed: a closed surface")
    return surface


def level_set(
    distance: Callable[[Floats], tuple[Floats, Floats]],
    low_mm: Floats,
    high_mm: Floats,
    spacing_mm: float,
) -> ClosedSurface:
    """Triangles of about one spacing whose points lie on the surface φ = 0.

    Args:
        distance: returns φ (n,) and its gradients (n, 3) at (n, 3) points.
        low_mm: (3,) corner of a box around the surface.
        high_mm: (3,) opposite corner of the box.
        spacing_mm: spacing of the grid whose cells cut the surface.
    """
    import pyvista as pv

    count = np.ceil((high_mm - low_mm) / spacing_mm).astype(int) + 1
    low = (low_mm + high_mm - spacing_mm * (count - 1)) / 2  # the grid is as symmetric as the box
    grid = pv.ImageData(dimensions=count, spacing=3 * (spacing_mm,), origin=low)
    grid["phi"] = distance(np.asarray(grid.points, dtype=float))[0]
    contour = grid.contour([0.0], scalars="phi", method="flying_edges").clean()
    points = np.asarray(contour.points, dtype=float)
    for _ in range(PROJECTIONS):
        value, gradient = distance(points)
        points = points - (value / (gradient**2).sum(axis=1))[:, None] * gradient
    triangles = np.asarray(contour.regular_faces, dtype=np.int64)
    surface = ClosedSurface(points, triangles)
    if surface.volume_mm3 < 0:
        surface = ClosedSurface(points, triangles[:, ::-1].copy())
    return surface


def locator(points: Floats, triangles: Ints) -> Any:
    """VTK's search tree of triangles."""
    from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

    tree: Any = vtkStaticCellLocator()  # its hints lack the references that it fills
    tree.SetDataSet(ClosedSurface(points, triangles).polydata())
    tree.BuildLocator()
    return tree


def nearest(points: Floats, triangles: Ints, at: Floats) -> tuple[Ints, Floats]:
    """Rows (k,) of the triangles that are nearest to (k, 3) points, and distances (k,) (mm)."""
    surface = ClosedSurface(points, triangles).polydata()
    rows, close = surface.find_closest_cell(at, return_closest_point=True)
    return np.asarray(rows, dtype=np.int64), np.linalg.norm(close - at, axis=1)

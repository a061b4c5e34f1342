"""The mesh morph changes the thicknesses of the strain-limiting and of the stretching region.

Region A lies between the back of the base layer, x = 0, and the plane x = d, region B beyond it.
Their thicknesses change by the shares ξ1 and ξ2, and each plane x = const stays a plane:

    x' = x (1 + ξ1)                         for x ≤ d,
    x' = d (1 + ξ1) + (x − d) (1 + ξ2)      for x > d,

which is *moveNodePoints* of "Simulation Data Driven Design Optimization for Reconfigurable Soft
Gripper System". Vertices move; the middle of a second-order edge moves with its ends and keeps its
place between them, so that straight edges stay straight where they cross x = d. Faces along x, and
faces across it, stay planes, so a finger made of boxes is morphed exactly on any mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from dolfingrip.meshes.cells import BY_NODES
from dolfingrip.meshes.measures import jacobians
from dolfingrip.meshes.solid import Floats, Ints, MeshError, SolidMesh

_NO_EDGES: Final = np.empty((0, 3), dtype=np.int64)


@dataclass(frozen=True, slots=True)
class MorphMap:
    """The relative changes of the two regions' thicknesses, and the plane between the regions.

    Attributes:
        xi1, xi2: relative change of the thickness of region A and of region B, above −1.
        d_mm: x of the plane between the regions in the mesh that is to be moved.
    """

    xi1: float
    xi2: float
    d_mm: float

    @property
    def is_identity(self) -> bool:
        """True if no point moves."""
        return self.xi1 == 0 and self.xi2 == 0

    def inverse(self) -> MorphMap:
        """The morph that undoes this one.

        Raises:
            MeshError: if a region has no thickness left.
        """
        if min(self.xi1, self.xi2) <= -1:
            raise MeshError(f"{self}: cannot be undone; allowed: xi1 and xi2 above -1")
        return MorphMap(
            -self.xi1 / (1 + self.xi1), -self.xi2 / (1 + self.xi2), self.d_mm * (1 + self.xi1)
        )

    def moved(self, x: Floats) -> Floats:
        """New positions x' (mm) of planes x = const, of any shape."""
        x = np.asarray(x, dtype=float)
        beyond = self.d_mm * (1 + self.xi1) + (x - self.d_mm) * (1 + self.xi2)
        return np.where(x <= self.d_mm, x * (1 + self.xi1), beyond)

    def slope(self, x: Floats) -> Floats:
        """dx'/dx at x, of any shape; on the plane between the regions it is that of region A."""
        return np.where(np.asarray(x) <= self.d_mm, 1 + self.xi1, 1 + self.xi2)

    def points(self, points: Floats, edges: Ints = _NO_EDGES) -> Floats:
        """Moved points.

        Args:
            points: points (mm), shape (n, 3).
            edges: node indices from :func:`second_order_edges`, shape (k, 3).
        """
        moved = points.copy()
        moved[:, 0] = self.moved(points[:, 0])
        if len(edges):
            middle, ends = edges[:, 0], edges[:, 1:]
            before, after = points[ends, 0], moved[ends, 0]
            bulge = points[middle, 0] - before.mean(axis=1)
            moved[middle, 0] = after.mean(axis=1) + bulge * self._secant(before, after)
        return moved

    def _secant(self, before: Floats, after: Floats) -> Floats:
        """Stretch of edges along x, shape (k,); the inverse morph's stretch is its inverse."""
        run, rise = np.diff(before)[:, 0], np.diff(after)[:, 0]
        # a difference as small as round-off has no meaning
        level = np.abs(run) <= 1e-9 * np.abs(before).max(axis=1, initial=1e-300)
        local = self.slope(before.mean(axis=1))
        return np.where(level, local, rise / np.where(level, 1.0, run))

    def __str__(self) -> str:
        return f"morph with xi1 = {self.xi1:g}, xi2 = {self.xi2:g}"


def morphed(mesh: SolidMesh, morph: MorphMap) -> SolidMesh:
    """Move the points of a mesh by a morph.

    Args:
        mesh: mesh of the finger (mm).
        morph: how its points move.

    Returns:
        The mesh with moved points; cells and groups stay.

    Raises:
        MeshError: if elements are turned inside out; the line names ξ.
    """
    if morph.is_identity:
        return mesh
    new = replace(mesh, points=morph.points(mesh.points, second_order_edges(mesh.cells)))
    least = jacobians(new).min(axis=1)
    number = int((least <= 0).sum())
    if number:
        raise MeshError(
            f"{morph}: turns {number} of {len(least)} elements inside out "
            f"(Jacobian {least.min():.3g} mm³); allowed: xi nearer to 0, both above -1"
        )
    return new


def second_order_edges(cells: Ints) -> Ints:
    """Nodes in the middle and at the ends of each second-order edge, shape (k, 3).

    Args:
        cells: cells as in :class:`SolidMesh`, shape (m, nodes).
    """
    shape = BY_NODES[cells.shape[1]]
    if cells.shape[1] == shape.corners:
        return _NO_EDGES
    middles = cells[:, shape.corners :, None]
    edges = np.concatenate([middles, cells[:, shape.edges]], axis=2).reshape(-1, 3)
    return edges[np.unique(edges[:, 0], return_index=True)[1]]

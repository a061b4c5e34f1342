"""A solid of tetrahedra with named groups of boundary facets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dolfingrip.config import ConfigError

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

FACES: Final = np.array(
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 9, 7], [1, 2, 3, 5, 8, 9], [0, 3, 2, 7, 8, 6]]
)
"""Local nodes of a tetrahedron's faces: corners seen from outside, then their edges' midpoints.

The order of the faces is Abaqus' (S1 to S4) too.
"""

EXCHANGED: Final = np.array([0, 1, 2, 3, 4, 5, 6, 7, 9, 8])
"""Nodes of a second-order tetrahedron in the order of VTK, Abaqus and meshio, and back."""

EDGES: Final = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]])
"""Corners of the edges whose midpoints are the local nodes 4 to 9."""


class MeshError(ConfigError):
    """A mesh that cannot be made, read or used, said in one line."""


@dataclass(frozen=True, slots=True)
class SolidMesh:
    """Tetrahedra of first or second order and the facets of each surface group.

    Attributes
    ----------
    points
        Coordinates in mm, shape (n, 3).
    tetrahedra
        Node indices, shape (m, 4) or (m, 10), corners first, then the midpoints of the
        edges 01, 12, 02, 03, 23, 13: Gmsh's order. VTK, Abaqus and meshio exchange the
        last two, see :data:`EXCHANGED`.
    facets
        Node indices of each surface group's triangles, shape (k, 3) or (k, 6), corners
        counter-clockwise seen from outside the solid (normals point out of it, into the
        cavity on the cavity's surface), then the midpoints of the edges 01, 12, 20.
    """

    points: Floats
    tetrahedra: Ints
    facets: dict[str, Ints]

    @property
    def order(self) -> int:
        """Order of the elements, 1 or 2."""
        return 1 if self.tetrahedra.shape[1] == 4 else 2


def faces(tetrahedra: Ints) -> Ints:
    """All faces of all tetrahedra, outward, face ``f`` of tetrahedron ``t`` in row ``4 t + f``.

    Parameters
    ----------
    tetrahedra
        Shape (m, 4) or (m, 10).

    Returns
    -------
    Ints
        Shape (4 m, 3) or (4 m, 6).
    """
    nodes = 3 if tetrahedra.shape[1] == 4 else 6
    return tetrahedra[:, FACES[:, :nodes]].reshape(-1, nodes)


def labels(triangles: Ints) -> Ints:
    """A number from 0 for each triangle, equal where the corners are, shape (k,).

    Parameters
    ----------
    triangles
        Node indices, corners first and in any order, shape (k, >= 3).
    """
    corners = np.sort(triangles[:, :3], axis=1)
    order = np.lexsort(corners.T)
    new = np.ones(len(corners), dtype=np.int64)
    new[1:] = (np.diff(corners[order], axis=0) != 0).any(axis=1)
    found = np.empty(len(corners), dtype=np.int64)
    found[order] = np.cumsum(new) - 1
    return found


def boundary(tetrahedra: Ints) -> Ints:
    """Rows of :func:`faces` that only one tetrahedron has, shape (k,)."""
    label = labels(faces(tetrahedra))
    return np.flatnonzero(np.bincount(label)[label] == 1)


def match(triangles: Ints, tetrahedra: Ints) -> Ints:
    """Boundary face of each triangle: a row of :func:`faces`, or -1 where there is none.

    Parameters
    ----------
    triangles
        Node indices, corners first and in any order, shape (k, >= 3).
    tetrahedra
        Shape (m, 4) or (m, 10).

    Returns
    -------
    Ints
        Shape (k,).
    """
    rows = boundary(tetrahedra)
    label = labels(np.concatenate([faces(tetrahedra)[rows, :3], triangles[:, :3]]))
    row_of = np.full(len(label), -1, dtype=np.int64)
    row_of[label[: len(rows)]] = rows
    return row_of[label[len(rows) :]]


def assemble(points: Floats, tetrahedra: Ints, triangles: dict[str, Ints]) -> SolidMesh:
    """A mesh from triangles in any orientation, without the points that no element has.

    Parameters
    ----------
    points
        Shape (n, 3), mm.
    tetrahedra
        Shape (m, 4) or (m, 10), node order as in :class:`SolidMesh`.
    triangles
        Corners of each group's triangles, shape (k, >= 3).

    Raises
    ------
    MeshError
        Where a triangle is no face on the boundary of the tetrahedra.
    """
    used, inverse = np.unique(tetrahedra, return_inverse=True)
    new = np.full(len(points), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    compact = inverse.reshape(tetrahedra.shape).astype(np.int64)
    every = faces(compact)
    facets = {}
    for name, corners in triangles.items():
        rows = match(new[corners[:, :3]], compact)
        if (rows < 0).any():
            raise MeshError(
                f"group {name}: {(rows < 0).sum()} triangles not on the solid's surface"
            )
        facets[name] = every[np.unique(rows)]
    return SolidMesh(np.ascontiguousarray(points[used]), compact, facets)

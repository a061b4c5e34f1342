"""A solid of finite elements with named groups of boundary facets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dolfingrip.config import ConfigError
from dolfingrip.meshes.cells import BY_NODES, FACET_CORNERS, CellShape

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

MOST_ELEMENTS: Final = 10_000_000
"""Meshes of more would not fit into memory."""

EXCHANGED: Final = np.array([0, 1, 2, 3, 4, 5, 6, 7, 9, 8])
"""Nodes of a second-order tetrahedron in the order of VTK, Abaqus and meshio, and back."""


class MeshError(ConfigError):
    """A mesh that cannot be made, read or used, said in one line."""


@dataclass(frozen=True, slots=True)
class SolidMesh:
    """Elements of one shape and order and the facets of each surface group.

    Attributes
    ----------
    points
        Coordinates in mm, shape (n, 3).
    cells
        Node indices: of tetrahedra, shape (m, 4) or (m, 10), or of hexahedra, shape (m, 8)
        or (m, 20); corners first, then the midpoints of the edges, in Gmsh's order (see
        :class:`~dolfingrip.meshes.cells.CellShape`). In tetrahedra of second order VTK,
        Abaqus and meshio exchange the last two, see :data:`EXCHANGED`.
    facets
        Node indices of each surface group's triangles, shape (k, 3) or (k, 6), or
        quadrilaterals, shape (k, 4) or (k, 8): corners counter-clockwise seen from outside
        the solid (normals point out of it, into the cavity on the cavity's surface), then
        the midpoints of the edges from each corner to the next.
    """

    points: Floats
    cells: Ints
    facets: dict[str, Ints]

    @property
    def shape(self) -> CellShape:
        """Shape of the elements."""
        return BY_NODES[self.cells.shape[1]]

    @property
    def order(self) -> int:
        """Order of the elements, 1 or 2."""
        return self.shape.order(self.cells.shape[1])


def faces(cells: Ints) -> Ints:
    """All faces of all cells, outward, face ``f`` of cell ``c`` in row ``faces · c + f``.

    Parameters
    ----------
    cells
        As in :class:`SolidMesh`, shape (m, nodes).

    Returns
    -------
    Ints
        Shape (m · faces, nodes of a facet).
    """
    shape = BY_NODES[cells.shape[1]]
    nodes = shape.facet_corners * shape.order(cells.shape[1])
    return cells[:, shape.faces[:, :nodes]].reshape(-1, nodes)


def labels(facets: Ints) -> Ints:
    """A number from 0 for each facet, equal where the corners are, shape (k,).

    Parameters
    ----------
    facets
        Node indices, corners first and in any order, shape (k, nodes).
    """
    corners = np.sort(facets[:, : FACET_CORNERS[facets.shape[1]]], axis=1)
    order = np.lexsort(corners.T)
    new = np.ones(len(corners), dtype=np.int64)
    new[1:] = (np.diff(corners[order], axis=0) != 0).any(axis=1)
    found = np.empty(len(corners), dtype=np.int64)
    found[order] = np.cumsum(new) - 1
    return found


def boundary(cells: Ints) -> Ints:
    """Rows of :func:`faces` that only one cell has, shape (k,)."""
    label = labels(faces(cells))
    return np.flatnonzero(np.bincount(label)[label] == 1)


def match(facets: Ints, cells: Ints) -> Ints:
    """Boundary face of each facet: a row of :func:`faces`, or -1 where there is none.

    Parameters
    ----------
    facets
        Node indices, corners first and in any order, shape (k, nodes).
    cells
        As in :class:`SolidMesh`.

    Returns
    -------
    Ints
        Shape (k,).
    """
    rows = boundary(cells)
    corners = BY_NODES[cells.shape[1]].facet_corners
    label = labels(np.concatenate([faces(cells)[rows, :corners], facets[:, :corners]]))
    row_of = np.full(len(label), -1, dtype=np.int64)
    row_of[label[: len(rows)]] = rows
    return row_of[label[len(rows) :]]


def assemble(points: Floats, cells: Ints, facets: dict[str, Ints]) -> SolidMesh:
    """A mesh from facets in any orientation, without the points that no element has.

    Parameters
    ----------
    points
        Shape (n, 3), mm.
    cells
        As in :class:`SolidMesh`.
    facets
        Corners of each group's facets first, shape (k, nodes).

    Raises
    ------
    MeshError
        Where a facet is no face on the boundary of the solid.
    """
    used, inverse = np.unique(cells, return_inverse=True)
    new = np.full(len(points), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    compact = inverse.reshape(cells.shape).astype(np.int64)
    every = faces(compact)
    corners = BY_NODES[cells.shape[1]].facet_corners
    groups = {}
    for name, found in facets.items():
        rows = match(new[found[:, :corners]], compact)
        if (rows < 0).any():
            raise MeshError(f"group {name}: {(rows < 0).sum()} facets not on the solid's surface")
        groups[name] = every[np.unique(rows)]
    return SolidMesh(np.ascontiguousarray(points[used]), compact, groups)

"""Shapes of the solid's elements: corners, edges and faces in Gmsh's order, and shape functions.

Triangles and tetrahedra have Lagrange's shape functions, and so do quadrilaterals and hexahedra of
order 1. Those of order 2 have serendipity shape functions, polynomials of superlinear degree 2
(Arnold & Awanou, 2011, "The serendipity family of finite elements").
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CellShape:
    """The shape of an element of first order, or of second order with a node amid each edge.

    Attributes:
        name, facet_name: basix' names of the element and of its faces.
        corners, facet_corners: number of corners of the element and of a face.
        edges: corners of each edge, shape (e, 2); the node amid edge ``i`` is ``corners + i``.
        faces: local nodes of each face, shape (f, 2 · facet_corners): the corners counter-clockwise
            seen from outside, then the nodes amid the edges from each corner to the next. The order
            of the faces is Abaqus' (S1, S2, …).
        vtk_edges: rows of ``edges`` in the order of VTK, Abaqus and meshio, shape (e,).
        reference: coordinates of the reference element's corners, shape (corners, 3).
        spokes: neighbours of each corner, so that the edges to them are right-handed, (corners, 3).
    """

    name: str
    facet_name: str
    edges: Ints
    face_corners: Ints
    vtk_edges: Ints
    reference: Floats
    spokes: Ints
    faces: Ints = field(init=False)

    def __post_init__(self) -> None:
        ends = np.stack([self.face_corners, np.roll(self.face_corners, -1, axis=1)], axis=2)
        same = np.sort(ends, axis=2)[:, :, None] == np.sort(self.edges, axis=1)
        middles = self.corners + same.all(axis=3).argmax(axis=2)
        object.__setattr__(self, "faces", np.hstack([self.face_corners, middles]))

    @property
    def plural(self) -> str:
        """Plural of the element's name."""
        return self.name.removesuffix("on") + "a"

    @property
    def corners(self) -> int:
        """Number of the element's corners."""
        return int(self.edges.max()) + 1

    @property
    def facet_corners(self) -> int:
        """Number of a face's corners."""
        return int(self.face_corners.shape[1])

    def order(self, nodes: int) -> int:
        """Order of an element with so many nodes, 1 or 2."""
        return 1 if nodes == self.corners else 2

    @property
    def mirror(self) -> Ints:
        """Nodes of an element of second order, from which its mirror image is right-handed."""
        turned = self.reference[:, [1, 0, 2]]
        corner = (turned[:, None] == self.reference).all(axis=2).argmax(axis=1)
        ends = np.sort(corner[self.edges], axis=1)
        middle = (ends[:, None] == np.sort(self.edges, axis=1)).all(axis=2).argmax(axis=1)
        return np.concatenate([corner, self.corners + middle])

    def vtk(self, nodes: int) -> Ints:
        """Nodes of an element, given their number, in the order of VTK, Abaqus and meshio."""
        order = np.concatenate([np.arange(self.corners), self.corners + self.vtk_edges])
        return order[:nodes]


TETRAHEDRON: Final = CellShape(
    "tetrahedron",
    "triangle",
    np.array([[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    vtk_edges=np.array([0, 1, 2, 3, 5, 4]),
    reference=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float),
    spokes=np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
)

HEXAHEDRON: Final = CellShape(
    "hexahedron",
    "quadrilateral",
    np.array(
        [
            *([0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3]),
            *([2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]),
        ]
    ),
    np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]),
    vtk_edges=np.array([0, 3, 5, 1, 8, 10, 11, 9, 2, 4, 6, 7]),
    reference=np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
        dtype=float,
    ),
    spokes=np.array(
        [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]]
    ),
)

BY_NODES: Final = {4: TETRAHEDRON, 10: TETRAHEDRON, 8: HEXAHEDRON, 20: HEXAHEDRON}
"""The shape of an element for each number of nodes."""

FACET_CORNERS: Final = {3: 3, 6: 3, 4: 4, 8: 4}
"""Number of corners of a facet for each number of nodes."""


def to_vtk(cells: Ints) -> Ints:
    """Cells of :class:`~dolfingrip.meshes.solid.SolidMesh` in VTK's order of nodes."""
    return cells[:, BY_NODES[cells.shape[1]].vtk(cells.shape[1])]


def from_vtk(cells: Ints) -> Ints:
    """Reorder the nodes of cells from VTK's order.

    Args:
        cells: (n, nodes) cells in VTK's order of nodes.

    Returns:
        (n, nodes) cells in the order of :class:`~dolfingrip.meshes.solid.SolidMesh`.
    """
    return cells[:, np.argsort(BY_NODES[cells.shape[1]].vtk(cells.shape[1]))]


_FACETS: Final = {3: TETRAHEDRON.reference[:3, :2], 4: HEXAHEDRON.reference[:4, :2]}
"""Corners of the reference facet, by the number of corners."""


@dataclass(frozen=True, eq=False)
class ShapeFunctions:
    """Polynomials that are 1 at one node of a reference element and 0 at the others.

    Attributes:
        exponents: exponents of each monomial, shape (nodes, d).
        coefficients: coefficients of each monomial in each shape function, shape (nodes, nodes).
    """

    exponents: Ints
    coefficients: Floats

    def values(self, at: Floats) -> Floats:
        """Values at points (q, d) of the reference element, shape (q, nodes)."""
        return _powers(at, self.exponents) @ self.coefficients

    def gradients(self, at: Floats) -> Floats:
        """Gradients at points (q, d) of the reference element, shape (q, nodes, d)."""
        along = []
        for axis in range(self.exponents.shape[1]):
            lower = self.exponents.copy()
            lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
            monomials = self.exponents[:, axis] * _powers(at, lower)
            along.append(monomials @ self.coefficients)
        return np.stack(along, axis=2)


@cache
def of_cell(nodes: int) -> ShapeFunctions:
    """Shape functions of an element.

    Args:
        nodes: number of the element's nodes: 4, 8, 10 or 20.

    Returns:
        The functions on the reference element.
    """
    shape = BY_NODES[nodes]
    return _make(shape.reference, shape.edges, nodes)


@cache
def of_facet(nodes: int) -> ShapeFunctions:
    """Shape functions of a facet.

    Args:
        nodes: number of the facet's nodes: 3, 4, 6 or 8.

    Returns:
        The functions on the reference facet.
    """
    number = FACET_CORNERS[nodes]
    edges = np.array([[i, (i + 1) % number] for i in range(number)])
    return _make(_FACETS[number], edges, nodes)


def _make(corners: Floats, edges: Ints, nodes: int) -> ShapeFunctions:
    at = np.concatenate([corners, corners[edges].mean(axis=1)])[:nodes]
    d = corners.shape[1]
    order = 1 if nodes == len(corners) else 2
    every = np.array(list(product(range(order + 1), repeat=d)))
    if len(corners) == d + 1:
        degree = every.sum(axis=1)
    else:
        degree = np.where(every > 1, every, 0).sum(axis=1)
    exponents = every[degree <= order]
    coefficients = np.linalg.inv(_powers(at, exponents))
    return ShapeFunctions(exponents, np.asarray(coefficients, dtype=float))


def _powers(at: Floats, exponents: Ints) -> Floats:
    """Monomials at points, shape (q, monomials)."""
    powers: Floats = (at[:, None, :] ** exponents).prod(axis=2)
    return powers

"""Shape functions of the elements and facets of :class:`~dolfingrip.meshes.solid.SolidMesh`.

Triangles and tetrahedra have Lagrange's shape functions, and so do quadrilaterals and hexahedra of
order 1. Those of order 2 have serendipity shape functions, polynomials of superlinear degree 2
(Arnold & Awanou, 2011, "The serendipity family of finite elements").
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Final

import numpy as np

from dolfingrip.meshes.cells import BY_NODES, FACET_CORNERS, HEXAHEDRON, TETRAHEDRON, Floats, Ints

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

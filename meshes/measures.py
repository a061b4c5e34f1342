"""Volumes, lengths, angles and Jacobians of a mesh."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from dolfingrip.meshes import cells
from dolfingrip.meshes.cells import FACET_CORNERS, HEXAHEDRON, TETRAHEDRON
from dolfingrip.meshes.solid import Floats, Ints, SolidMesh


def _cube(points: ArrayLike, dimension: int) -> Floats:
    """All points of a grid whose coordinates are ``points``, shape (q, dimension)."""
    return np.array(list(product(np.asarray(points), repeat=dimension)), dtype=float)


def _gauss(number: int, dimension: int) -> tuple[Floats, Floats]:
    """Points and weights of Gauss' quadrature on the unit square or cube."""
    points, weights = np.polynomial.legendre.leggauss(number)
    return _cube((points + 1) / 2, dimension), _cube(weights / 2, dimension).prod(axis=1)


_CHECKED: Final = {
    4: np.array([[0.25, 0.25, 0.25]]),
    10: np.array([c for c in product(range(4), repeat=3) if sum(c) <= 3]) / 3,
    8: _cube(np.linspace(0, 1, 3), 3),
    20: _cube(np.linspace(0, 1, 6), 3),
}
"""Points at which Jacobians are checked, by the number of an element's nodes. The values there
determine the polynomial.

The Jacobian is a polynomial of degree 0 and 3 in a tetrahedron, and of degree 2 and 5 in each
coordinate in a hexahedron.
"""

FACET_QUADRATURE: Final = {
    3: (
        np.array(
            [[a, a] for a in (0.445948490915965, 0.091576213509771)]
            + [[1 - 2 * a, a] for a in (0.445948490915965, 0.091576213509771)]
            + [[a, 1 - 2 * a] for a in (0.445948490915965, 0.091576213509771)]
        ),
        np.tile([0.223381589678011, 0.109951743655322], 3) / 2,
    ),
    4: _gauss(3, 2),
}
"""Points and weights by a facet's corners, exact for the volume behind facets of order 2.

On the triangle for degree 4 (Dunavant 1985), on the square for degree 5 in each coordinate.
"""

CELL_QUADRATURE: Final = {
    TETRAHEDRON: (np.array([[0.25, 0.25, 0.25]]), np.array([1 / 6])),
    HEXAHEDRON: _gauss(2, 3),
}
"""Points and weights, exact for the first moments of elements with straight edges."""


def jacobians(mesh: SolidMesh) -> Floats:
    """Determinant of each element's Jacobian (mm³), shape (m, points).

    A first-order tetrahedron has one, which is constant. Those of a second-order tetrahedron and of
    hexahedra of first and second order are polynomials, given at the 20, 27 and 216 points that
    determine them. For a straight tetrahedron it is six times the volume, for a box once.

    Args:
        mesh: in mm.
    """
    nodes = mesh.cells.shape[1]
    x = mesh.points[mesh.cells]
    gradients = cells.of_cell(nodes).gradients(_CHECKED[nodes])
    return np.stack([_determinants(x, at) for at in gradients], axis=1)


def _determinants(x: Floats, gradients: Floats) -> Floats:
    """Jacobian determinants of elements (m, nodes, 3) at one point, shape (m,)."""
    columns = np.einsum("nk,mni->kmi", gradients, x)
    determinants: Floats = np.einsum("mi,mi->m", columns[0], np.cross(columns[1], columns[2]))
    return determinants


def enclosed_volume(points: Floats, facets: Ints) -> float:
    """Integral of x·n / 3 over the facets (mm³); facets of a closed surface enclose this volume.

    A surface that ends on planes through the origin encloses its volume with them.

    Args:
        points: shape (n, 3), mm.
        facets: as in :class:`SolidMesh`, shape (k, nodes).
    """
    x = points[facets]
    nodes = facets.shape[1]
    at, weights = FACET_QUADRATURE[FACET_CORNERS[nodes]]
    functions = cells.of_facet(nodes)
    total = 0.0
    for value, gradient, weight in zip(
        functions.values(at), functions.gradients(at), weights, strict=True
    ):
        along = np.einsum("nj,kni->jki", gradient, x)
        here = np.einsum("n,kni->ki", value, x)
        total += weight * float(np.einsum("ki,ki->", here, np.cross(along[0], along[1]))) / 3
    return total


def _spokes(mesh: SolidMesh) -> Floats:
    """Right-handed edges from each corner, shape (m, corners, 3, 3), mm."""
    x = mesh.points[mesh.cells[:, : mesh.shape.corners]]
    return x[:, mesh.shape.spokes] - x[:, :, None]


def scaled_jacobians(mesh: SolidMesh) -> Floats:
    """Smallest ratio of an element's corner sine and that of the regular element, shape (m,).

    A corner's sine is the determinant of the unit vectors along its three edges (Knupp,
    2000, "Achieving finite element mesh quality via optimization of the Jacobian matrix
    norm", part II). The ratio is 1 for the regular tetrahedron and for boxes, 0 for flat elements.
    """
    edges = _spokes(mesh)
    edges /= np.linalg.norm(edges, axis=3, keepdims=True)
    regular = np.sqrt(0.5) if mesh.shape is TETRAHEDRON else 1.0
    least: Floats = np.linalg.det(edges).min(axis=1) / regular
    return least


def dihedral_angles(mesh: SolidMesh) -> Floats:
    """Angles between the faces of each element, at both ends of each edge, rad.

    Shape (m, 3 · corners).
    """
    edges = _spokes(mesh)
    # normals of the faces between an edge and the next; the edge i lies between i - 1 and i
    normals = np.cross(edges, np.roll(edges, -1, axis=2))
    normals /= np.linalg.norm(normals, axis=3, keepdims=True)
    cosines = -np.einsum("mcei,mcei->mce", normals, np.roll(normals, 1, axis=2))
    return np.arccos(np.clip(cosines, -1, 1)).reshape(len(mesh.cells), -1)


def edge_lengths(mesh: SolidMesh) -> Floats:
    """Lengths of each element's edges from corner to corner, shape (m, edges), mm."""
    ends = mesh.points[mesh.cells[:, mesh.shape.edges]]
    lengths: Floats = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    return lengths


def moments(mesh: SolidMesh) -> tuple[float, Floats]:
    """Volume and first moment of a solid.

    Second-order elements are integrated exactly where their edges are straight.

    Args:
        mesh: the solid (mm).

    Returns:
        Volume (mm³), and first moment ∫ x dV (mm⁴), shape (3,).
    """
    at, weights = CELL_QUADRATURE[mesh.shape]
    functions = cells.of_cell(mesh.shape.corners)
    x = mesh.points[mesh.cells[:, : mesh.shape.corners]]
    moment: Floats = np.zeros(3)
    volume = 0.0
    for value, gradient, weight in zip(
        functions.values(at), functions.gradients(at), weights, strict=True
    ):
        part = weight * _determinants(x, gradient)
        moment += part @ np.einsum("n,mni->mi", value, x)
        volume += float(part.sum())
    return volume, moment


def centroid(mesh: SolidMesh) -> Floats:
    """Centre of gravity of a homogeneous solid.

    Args:
        mesh: the solid (mm).

    Returns:
        Centre of gravity (mm), shape (3,).
    """
    volume, moment = moments(mesh)
    return np.asarray(moment / volume, dtype=float)


def moment_gradients(mesh: SolidMesh) -> tuple[Floats, Floats]:
    """Derivatives of :func:`moments` by the points.

    The middle of an edge follows its ends; its own motion counts for nothing.

    Args:
        mesh: the solid (mm).

    Returns:
        Shape (n, 3) of the volume (mm²), and (3, n, 3) of the first moment (mm³).
    """
    at, weights = CELL_QUADRATURE[mesh.shape]
    functions = cells.of_cell(mesh.shape.corners)
    corners = mesh.cells[:, : mesh.shape.corners]
    x = mesh.points[corners]
    by_volume = np.zeros((len(mesh.points), 3))
    by_moment = np.zeros((3, len(mesh.points), 3))
    for value, gradient, weight in zip(
        functions.values(at), functions.gradients(at), weights, strict=True
    ):
        jacobian = np.einsum("nk,mni->mik", gradient, x)
        part = weight * np.linalg.det(jacobian)
        # Jacobi's formula
        growth = np.einsum("m,nk,mki->mni", part, gradient, np.linalg.inv(jacobian))
        place = np.einsum("n,mni->mi", value, x)
        np.add.at(by_volume, corners, growth)
        for axis in range(3):
            moving = place[:, None, axis, None] * growth
            moving[:, :, axis] += part[:, None] * value
            np.add.at(by_moment[axis], corners, moving)
    return by_volume, by_moment


def centroid_gradients(mesh: SolidMesh) -> Floats:
    """Derivatives of :func:`centroid` by the points.

    Args:
        mesh: the solid (mm).

    Returns:
        Shape (3, n, 3), as in :func:`moment_gradients`.
    """
    volume, moment = moments(mesh)
    by_volume, by_moment = moment_gradients(mesh)
    return np.asarray((by_moment - np.multiply.outer(moment / volume, by_volume)) / volume)

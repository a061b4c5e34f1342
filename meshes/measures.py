"""Volumes, lengths, angles and Jacobians of a mesh."""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.meshes.solid import EDGES, Floats, Ints, SolidMesh, faces

_LATTICE: Final = (
    np.array([[i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)]) / 3
)
"""Points at which Jacobians are checked; they determine that of a second-order element."""

_TRIANGLE_POINTS: Final = np.array(
    [[a, a] for a in (0.445948490915965, 0.091576213509771)]
    + [[1 - 2 * a, a] for a in (0.445948490915965, 0.091576213509771)]
    + [[a, 1 - 2 * a] for a in (0.445948490915965, 0.091576213509771)]
)
_TRIANGLE_WEIGHTS: Final = np.tile([0.223381589678011, 0.109951743655322], 3) / 2
"""Quadrature on the triangle, exact for degree 4 (Dunavant 1985)."""


def jacobians(mesh: SolidMesh) -> Floats:
    """Determinant of each element's Jacobian (mm³), shape (m, 1) or (m, 20).

    That of a first-order element is constant, that of a second-order one a cubic, given at
    the 20 points that determine it.
    """
    corners = mesh.points[mesh.tetrahedra[:, :4]]
    if mesh.order == 1:
        return np.linalg.det(corners[:, 1:] - corners[:, :1])[:, None]
    nodes = mesh.points[mesh.tetrahedra]
    columns = [np.linalg.det(np.einsum("nk,mni->mki", g, nodes)) for g in _gradients(_LATTICE)]
    return np.stack(columns, axis=1)


def _gradients(at: Floats) -> Floats:
    """Gradients of the ten quadratic shape functions, shape (q, 10, 3), at points (q, 3)."""
    barycentric = np.column_stack([1 - at.sum(axis=1), at])
    d = np.vstack([-np.ones(3), np.eye(3)])
    corners = (4 * barycentric[:, :, None] - 1) * d
    i, j = EDGES.T
    middles = 4 * (barycentric[:, i, None] * d[j] + barycentric[:, j, None] * d[i])
    return np.concatenate([corners, middles], axis=1)


def enclosed_volume(points: Floats, facets: Ints) -> float:
    """Integral of x·n / 3 over the facets (mm³): the volume they enclose, where closed.

    A surface that ends on planes through the origin encloses its volume with them.

    Parameters
    ----------
    points
        Shape (n, 3), mm.
    facets
        Shape (k, 3) or (k, 6), as in :class:`SolidMesh`.
    """
    x = points[facets]
    if facets.shape[1] == 3:
        return float(np.einsum("ki,ki->", x[:, 0], np.cross(x[:, 1], x[:, 2]))) / 6
    total = 0.0
    for (r, s), weight in zip(_TRIANGLE_POINTS, _TRIANGLE_WEIGHTS, strict=True):
        t = 1 - r - s
        shape = [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
        along_r = [1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s]
        along_s = [1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)]
        at, dr, ds = (np.einsum("n,kni->ki", np.array(n), x) for n in (shape, along_r, along_s))
        total += weight * float(np.einsum("ki,ki->", at, np.cross(dr, ds))) / 3
    return total


def scaled_jacobians(mesh: SolidMesh) -> Floats:
    """Jacobian over the largest product of three edges that meet in a corner, times √2, (m,)."""
    corners = mesh.points[mesh.tetrahedra[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    length = edge_lengths(mesh)
    # edges 01 12 02 03 23 13 meet in the corners 0, 1, 2, 3 like this
    products = [length[:, e].prod(axis=1) for e in ([0, 2, 3], [0, 1, 5], [1, 2, 4], [3, 4, 5])]
    scaled: Floats = np.sqrt(2) * volume / np.max(products, axis=0)
    return scaled


def dihedral_angles(mesh: SolidMesh) -> Floats:
    """Angles between the faces of each tetrahedron, shape (m, 6), rad."""
    triangles = mesh.points[faces(mesh.tetrahedra[:, :4])].reshape(-1, 4, 3, 3)
    normals = np.cross(
        triangles[:, :, 1] - triangles[:, :, 0], triangles[:, :, 2] - triangles[:, :, 0]
    )
    normals /= np.linalg.norm(normals, axis=2)[:, :, None]
    i, j = EDGES.T
    cosines = -np.einsum("mei,mei->me", normals[:, i], normals[:, j])
    return np.arccos(np.clip(cosines, -1, 1))


def edge_lengths(mesh: SolidMesh) -> Floats:
    """Lengths of the edges 01, 12, 02, 03, 23, 13 of each tetrahedron, shape (m, 6), mm."""
    ends = mesh.points[mesh.tetrahedra[:, EDGES]]
    lengths: Floats = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    return lengths


def centroid(mesh: SolidMesh) -> Floats:
    """Centre of gravity of the homogeneous solid (mm), shape (3,).

    Second-order elements are integrated exactly where their edges are straight.
    """
    corners = mesh.points[mesh.tetrahedra[:, :4]]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1])
    centre: Floats = volumes @ corners.mean(axis=1) / volumes.sum()
    return centre


def centroid_rate(mesh: SolidMesh, velocity: Floats) -> Floats:
    """How fast :func:`centroid` moves as the points do, shape (3,).

    Parameters
    ----------
    mesh
        n points.
    velocity
        Of the points, shape (n, 3); that of an edge's middle does not count.
    """
    corners, moving = (each[mesh.tetrahedra[:, :4]] for each in (mesh.points, velocity))
    edges, changes = corners[:, 1:] - corners[:, :1], moving[:, 1:] - moving[:, :1]
    volumes = np.linalg.det(edges)
    # Jacobi's formula
    growth = volumes * np.trace(np.linalg.solve(edges, changes), axis1=1, axis2=2)
    centre = centroid(mesh)
    rate: Floats = (
        growth @ (corners.mean(axis=1) - centre) + volumes @ moving.mean(axis=1)
    ) / volumes.sum()
    return rate

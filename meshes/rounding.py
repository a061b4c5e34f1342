"""Curved faces of a solid whose mesh has only chords of them.

The facets tell the faces: where neighbours meet at a small angle they lie on one, and the corners
around a place are fitted by a surface of second degree. It is exact for cylinders; what is left of
the distance between chord and face is about a hundredth.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.meshes.cells import Floats, Ints
from dolfingrip.meshes.solid import SolidMesh, boundary, faces, parts_of

SMOOTH_DEG: Final = 45.0
"""Angle between neighbouring facets up to which they lie on one face."""
PLANE_DEG: Final = 0.05
"""The same on one plane."""
ALIKE: Final = 0.3
"""Tangent of half the angle up to which a plane and a curved face that meet have one normal."""
HIGHEST: Final = 0.12
"""Distance of a face from the middle of a chord, by the chord, up to which the face is followed:
that of an arc of 53°."""
_LAST: Final = 0.01
"""Factor of the height among the terms that are fitted: it is zero where corners leave it open."""
_OPEN: Final = 1e-6
"""Singular value, by the largest, below which corners leave a combination of terms open."""


class CurvedFaces:
    """Faces of a solid, told from its facets.

    Args:
        mesh: of first order.
    """

    def __init__(self, mesh: SolidMesh) -> None:
        self._points = mesh.points
        self._facets = facets = faces(mesh.cells)[boundary(mesh.cells)]
        count, at = len(mesh.points), mesh.points[facets]
        across = np.cross(at[:, 2] - at[:, 0], at[:, -1] - at[:, 1])
        self._normals = across / np.linalg.norm(across, axis=1)[:, None]
        pairs = _neighbours(facets)
        cosines = np.einsum("ni,ni->n", *self._normals[pairs.T])
        plane = parts_of(pairs[cosines > np.cos(np.radians(PLANE_DEG))], len(facets))
        # a strip between two lines of a cylinder is plane, too, but has no point within
        of_corner = np.repeat(plane, facets.shape[1])
        low, high = np.full(count, len(facets)), np.full(count, -1)
        np.minimum.at(low, facets.ravel(), of_corner)
        np.maximum.at(high, facets.ravel(), of_corner)
        self._flat = np.isin(plane, low[low == high])
        planes = np.where(self._flat, plane, -1)[pairs]
        smooth = cosines > np.cos(np.radians(SMOOTH_DEG))
        self._face = parts_of(pairs[smooth & (planes[:, 0] == planes[:, 1])], len(facets))
        order = np.argsort(facets.ravel(), kind="stable") // facets.shape[1]
        self._around = np.split(order, np.cumsum(np.bincount(facets.ravel(), minlength=count))[:-1])

    def off(self, corners: Ints) -> Floats:
        """How far the faces are from the middles of edges and of facets.

        Args:
            corners: (n, k) points whose middles they are; of what is within the solid, too.

        Returns:
            (n, 3) in mm; zero within the solid.
        """
        away = np.zeros((len(corners), 3))
        curved = np.zeros(len(self._points), dtype=bool)
        curved[self._facets[~self._flat]] = True
        for row in np.flatnonzero(curved[corners].all(axis=1)):
            nodes = corners[row]
            shared = set.intersection(*(set(self._around[i].tolist()) for i in nodes))
            facets = np.array(sorted(shared), dtype=np.int64)
            if not self._flat[facets].all():
                away[row] = self._way(nodes, facets)
        return away

    def _way(self, corners: Ints, facets: Ints) -> Floats:
        """The shortest way from the middle of corners onto the faces of facets that they are of."""
        normals, heights = [], []
        for face in np.unique(self._face[facets]):
            mine = facets[self._face[facets] == face]
            normal = self._normals[mine].sum(axis=0)
            normals.append(normal / np.linalg.norm(normal))
            flat = self._flat[mine].any()
            heights.append(0.0 if flat else self._height(corners, face, normals[-1]))
        way, *_ = np.linalg.lstsq(np.array(normals), np.array(heights), ALIKE)
        return np.asarray(way)

    def _height(self, corners: Ints, face: int, normal: Floats) -> float:
        """Height of a face above the middle of corners, from its points around them."""
        near = np.unique(np.concatenate([self._around[i] for i in corners]))
        points = self._points[np.unique(self._facets[near[self._face[near] == face]])]
        chord = float(np.linalg.norm(np.ptp(self._points[corners], axis=0)))
        away = (points - self._points[corners].mean(axis=0)) / chord
        u, v = np.linalg.svd(normal[None])[2][1:] @ away.T
        h, weights = away @ normal, 1 / np.einsum("ni,ni->n", away, away)
        # with h² they fit a circle about any axis across the normal
        terms = np.column_stack([np.full_like(u, _LAST), u, v, u * u + h * h, u * v, v * v + h * h])
        fitted, *_ = np.linalg.lstsq(terms * weights[:, None], h * weights, _OPEN)
        constant, curvature = _LAST * fitted[0], fitted[3] + fitted[5]
        height = 2 * constant / (1 + np.sqrt(max(1 - 4 * curvature * constant, 0.0)))
        return float(height * chord) if abs(height) <= HIGHEST else 0.0


def _neighbours(facets: Ints) -> Ints:
    """Facets that share an edge, (edges, 2)."""
    edges = np.sort(np.stack([facets, np.roll(facets, 1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    _, which, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    rows = np.argsort(which.ravel(), kind="stable") // facets.shape[1]
    first = (np.cumsum(count) - count)[count == 2]  # bodies that touch in an edge have four there
    return np.column_stack([rows[first], rows[first + 1]])

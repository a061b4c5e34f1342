"""Triangles of a whole finger's surface that pass through one another, found without ipctk."""

from __future__ import annotations

import numpy as np

from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.mechanics.contact.surface import Surface

CHUNK = 100
"""Edges that are compared with all triangles at once."""

PARALLEL = 1e-12
"""Size of a determinant, by the edges' lengths, below which an edge lies along a triangle."""


class WholeSurface:
    """All of a finger's boundary but its clamp and plane of symmetry, with its mirror image.

    Args:
        finger: model of a finger, half or whole.
    """

    def __init__(self, finger: FingerModel) -> None:
        domain, self._u = finger.site.domain, finger.model.u
        names = ("skin", "tip", *domain.cavities)
        made = Surface(self._u.function_space, domain, domain.facets(*names), None)
        self._surface = made.mirrored() if domain.half else made

    def passing(self) -> int:
        """Return how many edges pass through triangles at the present displacement."""
        points = self._surface.positions(self._u.x.array)
        return crossings(points, self._surface.triangles, self._surface.edges)


def crossings(points: np.ndarray, triangles: np.ndarray, edges: np.ndarray) -> int:
    """Count edges that pass through triangles with which they share no point (Möller & Trumbore).

    Args:
        points: (v, 3) positions.
        triangles: (m, 3) points of each.
        edges: (k, 2) points of each.
    """
    # by place along the longest way, so that edges of a chunk are near few triangles
    along = int(np.ptp(points, axis=0).argmax())
    triangles = triangles[np.argsort(points[triangles].min(axis=1)[:, along])]
    edges = edges[np.argsort(points[edges].min(axis=1)[:, along])]
    corners, ends = points[triangles], points[edges]
    low, high = corners.min(axis=1), corners.max(axis=1)
    highest = np.maximum.accumulate(high[:, along])
    near = []
    for first in range(0, len(edges), CHUNK):
        some = ends[first : first + CHUNK, None]
        start = np.searchsorted(highest, some[..., along].min())
        some_near = slice(start, np.searchsorted(low[:, along], some[..., along].max(), "right"))
        apart = (some.max(axis=2) < low[some_near]) | (some.min(axis=2) > high[some_near])
        near.append(np.argwhere(~apart.any(axis=2)) + np.array([first, start]))
    e, t = np.concatenate(near).T
    shared = (edges[e][:, :, None] == triangles[t][:, None, :]).any(axis=(1, 2))
    e, t = e[~shared], t[~shared]
    a, b, c = (corners[t, i] for i in range(3))
    start, way = ends[e, 0], ends[e, 1] - ends[e, 0]
    first, second, apart = b - a, c - a, start - a
    across = np.cross(way, second)
    size = np.einsum("ij,ij->i", first, across)
    sizes = [np.linalg.norm(each, axis=1) for each in (way, first, second)]
    told = np.abs(size) > PARALLEL * np.prod(sizes, axis=0)
    scale = np.where(told, size, np.inf)
    u = np.einsum("ij,ij->i", apart, across) / scale
    turned = np.cross(apart, first)
    v = np.einsum("ij,ij->i", way, turned) / scale
    s = np.einsum("ij,ij->i", second, turned) / scale
    return int((told & (u >= 0) & (v >= 0) & (u + v <= 1) & (s >= 0) & (s <= 1)).sum())

"""Contact facets wide enough for a barrier, merged from those of a rectilinear grid.

A structured mesh is graded by planes that run through the whole body, so that its skin has facets
narrower than the barrier's reach where nothing but a far-off edge wants them. Triangles so narrow
feel several others at once and trade them at every step of Newton's method.
"""

from __future__ import annotations

import numpy as np

NEAR = 1e-6
"""Part of the body's extent below which coordinates count as equal."""


def merge(facets: np.ndarray, rest: np.ndarray, spacing_mm: float) -> np.ndarray:
    """Quadrilaterals of second order with edges of at least ``spacing_mm`` where they can have.

    Args:
        facets: (m, 8) vertices of each, corners in turn, then the midpoints from each to the next.
        rest: (n, 3) reference positions (mm).
        spacing_mm: least distance of parallel edges; edges of the body stay, whatever it is.

    Returns:
        (k, 8) likewise; the nodes amid the edges are those nearest to their middles. The facets
        as they are where they do not lie in the planes of a rectilinear grid.
    """
    corners = rest[facets[:, :4]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = NEAR * np.ptp(rest, axis=0).max()
    flat = high - low < near
    aligned = (
        np.abs(corners - low[:, None]) < near) | (np.abs(corners - high[:, None]) < near
    )
    if not (flat.sum(axis=1) == 1).all() or not aligned.all():
        return facets
    normal = flat.argmax(axis=1)
    planes = [
        _kept(_distinct(rest[np.unique(facets[:, :4])][:, axis], near), low[normal == axis, axis], spacing_mm, near)
        for axis in range(3)
    ]
    centre = (low + high) / 2
    cell = np.stack([np.searchsorted(planes[a], centre[:, a] + near) for a in range(3)], axis=1)
    key = np.column_stack([normal, cell])
    _, group = np.unique(key, axis=0, return_inverse=True)
    merged = []
    for members in np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))[:-1]):
        merged.append(_outline(facets[members], rest, int(normal[members[0]]), near))
    return np.array(merged)


def _distinct(values: np.ndarray, near: float) -> np.ndarray:
    """Sorted values, those nearer than ``near`` as one."""
    values = np.sort(values)
    return values[np.concatenate([[True], np.diff(values) > near])]


def _kept(planes: np.ndarray, fixed: np.ndarray, spacing: float, near: float) -> np.ndarray:
    """Those planes of a grid that stay: ``fixed`` ones, the ends, others if wide apart."""
    ends = np.concatenate([fixed, planes[[0, -1]]])
    stay = (np.abs(planes[:, None] - ends) < near).any(axis=1)
    fixed_at = planes[stay]
    kept = [planes[0]]
    for plane, forced in zip(planes[1:], stay[1:], strict=True):
        following = fixed_at[fixed_at > plane + near]
        room = following[0] - plane if len(following) else np.inf
        if forced or (plane - kept[-1] >= spacing and room >= spacing):
            kept.append(plane)
    return np.array(kept)


def _outline(facets: np.ndarray, rest: np.ndarray, normal: int, near: float) -> np.ndarray:
    """(8,) corners in turn of a rectangle made of facets, then the nodes amid its edges."""
    if len(facets) == 1:
        return facets[0]
    nodes = np.unique(facets)
    axes = [axis for axis in range(3) if axis != normal]
    at = rest[nodes][:, axes]
    low, high = at.min(axis=0), at.max(axis=0)
    turn = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    corner = np.where(turn, high, low)
    # a node amid an edge lies on it and next to its middle
    middle = (corner + np.roll(corner, -1, axis=0)) / 2
    extent = high - low
    found = [np.abs(at - point).sum(axis=1).argmin() for point in corner]
    for i, point in enumerate(middle):
        across = i % 2 == 0  # the edges 0 and 2 run along the first axis
        on_edge = np.abs(at[:, int(across)] - point[int(across)]) < near
        along = np.abs(at[:, 1 - int(across)] - point[1 - int(across)])
        along[~on_edge | (along > 0.5 * extent[1 - int(across)] - near)] = np.inf
        found.append(along.argmin())
    return nodes[found]

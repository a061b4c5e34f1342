"""Evenly spread contact points on a rectilinear skin with facets of any size.

A structured mesh is graded by planes that run through the whole body. Some facets of its skin are
therefore narrower than the barrier's reach, and others are wide. Contact needs points whose density
follows from the contact zones. A point inside a facet moves with the facet's shape functions.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from dolfingrip.meshes import shape_functions

NEAR = 1e-6
"""Part of the body's extent below which coordinates count as equal."""


def resample(
    facets: np.ndarray, rest: np.ndarray, spacing_mm: float
) -> tuple[sp.csr_matrix, np.ndarray] | None:
    """Points at the corners of rectangles of about ``spacing_mm``, and triangles between them.

    Args:
        facets: (m, 8) nodes of quadrilaterals, corners in turn, then the midpoints from each
            to the next.
        rest: (n, 3) reference positions of the nodes (mm).
        spacing_mm: longest edge of a rectangle; except at walls, the shortest is half of it.

    Returns:
        (v, n) weights of the nodes in each point's position and displacement, and (k, 3) points
        of each triangle; None if the facets do not lie in the planes of a rectilinear grid.
    """
    corners = rest[facets[:, :4]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = NEAR * np.ptp(rest, axis=0).max()
    flat = high - low < near
    on_low = np.abs(corners - low[:, None]) < near
    aligned = on_low | (np.abs(corners - high[:, None]) < near)
    if not (flat.sum(axis=1) == 1).all() or not aligned.all():
        return None
    normal = flat.argmax(axis=1)
    lines = [
        _lines(low[normal == axis, axis], rest[:, axis], spacing_mm, near) for axis in range(3)
    ]
    points, rectangles = _rectangles(low, high, normal, lines, near)
    weights = _weights(points, facets, rest, low, high, near)
    # diagonals alternate, so that no direction is preferred
    return weights, rectangles[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def _lines(walls: np.ndarray, planes: np.ndarray, spacing: float, near: float) -> np.ndarray:
    """Coordinates of the samples along one axis: walls, and points fixed in the cells between.

    A share of its cell is what a sample keeps when the mesh is morphed, so that it stays the same
    point of the material. Samples that would come nearer than half the spacing are left out.
    """
    planes, fixed = _distinct(planes, near), _distinct(walls, near)
    fixed = _distinct(np.concatenate([fixed, planes[[0, -1]]]), near)
    candidates = np.concatenate(
        [np.linspace(a, b, math.ceil((b - a) / spacing) + 1)[:-1] for a, b in pairwise(planes)]
        + [planes[-1:]]
    )
    kept = [candidates[0]]
    for value in candidates[1:]:
        following = fixed[fixed > value - near][0]
        wall = following - value < near
        if wall or min(value - kept[-1], following - value) > (1 - NEAR) * spacing / 2:
            kept.append(value)
    return np.array(kept)


def _distinct(values: np.ndarray, near: float) -> np.ndarray:
    """Sorted values; values nearer than ``near`` become one."""
    values = np.sort(values)
    return values[np.concatenate([[True], np.diff(values) > near])]


def _rectangles(
    low: np.ndarray, high: np.ndarray, normal: np.ndarray, lines: list[np.ndarray], near: float
) -> tuple[np.ndarray, np.ndarray]:
    """(v, 3) points and (r, 4) points of each rectangle, in turn from alternating corners."""
    found: list[tuple[int, int, int, int]] = []
    for a, b, axis in zip(low, high, normal, strict=True):
        first, second = [i for i in range(3) if i != axis]
        level = int(np.abs(lines[axis] - a[axis]).argmin())
        inside = []
        for i in (first, second):
            centre = (lines[i][1:] + lines[i][:-1]) / 2
            inside.append(np.flatnonzero((centre > a[i] - near) & (centre < b[i] + near)))
        found += [(int(axis), level, int(i), int(j)) for i in inside[0] for j in inside[1]]
    cells = np.unique(np.array(found), axis=0)  # a centre on an edge belongs to two facets
    turn = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    index = np.empty((len(cells), 4, 3), dtype=np.int64)
    for axis in range(3):
        part = cells[:, 0] == axis
        first, second = [i for i in range(3) if i != axis]
        index[part, :, axis] = cells[part, 1, None]
        index[part, :, first] = cells[part, 2, None] + turn[:, 0]
        index[part, :, second] = cells[part, 3, None] + turn[:, 1]
    odd = cells[:, 1:].sum(axis=1) % 2 == 1
    index[odd] = np.roll(index[odd], 1, axis=1)
    unique, number = np.unique(index.reshape(-1, 3), axis=0, return_inverse=True)
    points = np.column_stack([lines[axis][unique[:, axis]] for axis in range(3)])
    return points, number.reshape(-1, 4)


def _weights(
    points: np.ndarray,
    facets: np.ndarray,
    rest: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    near: float,
) -> sp.csr_matrix:
    """(v, n) shape functions of a facet that holds each point, at the point."""
    functions = shape_functions.of_facet(facets.shape[1])
    rows, columns, values = [], [], []
    for i, point in enumerate(points):
        facet = int(((point > low - near) & (point < high + near)).all(axis=1).argmax())
        origin, first, _, last = rest[facets[facet, :4]]
        edges = np.array([first - origin, last - origin])
        local = (edges @ (point - origin)) / (edges**2).sum(axis=1)
        weight = functions.values(local[None])[0]
        weight[np.abs(weight) < NEAR] = 0.0
        rows += [i] * len(weight)
        columns += facets[facet].tolist()
        values += weight.tolist()
    found = sp.csr_matrix((values, (rows, columns)), shape=(len(points), len(rest)))
    found.eliminate_zeros()
    return found

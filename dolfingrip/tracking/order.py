"""Order along the body: which points are one finger's, in which order from end to end."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial.distance import cdist


def fingers(points: np.ndarray, groups: int) -> list[np.ndarray]:
    """Divide points among fingers, and order each finger's by the body's shape.

    Args:
        points: (n, 2) places at rest.
        groups: number of fingers.

    Returns:
        For each finger, from left to right, the numbers of its points along it.
    """
    tree = minimum_spanning_tree(cdist(points, points)).toarray()
    for _ in range(groups - 1):  # the widest gaps are those between fingers
        tree[np.unravel_index(tree.argmax(), tree.shape)] = 0.0
    _, labels = connected_components(tree, directed=False)
    members = [np.flatnonzero(labels == label) for label in range(labels.max() + 1)]
    members.sort(key=lambda finger: float(points[finger, 0].mean()))
    return [finger[_path(points[finger])] for finger in members]


def _path(points: np.ndarray) -> np.ndarray:
    """The shortest way through points, from one end to the other; it goes on as it bends."""
    away = cdist(points, points)
    best, least = list(range(len(points))), np.inf
    for start in range(len(points)):
        way = [start]
        while len(way) < len(points):
            left = [i for i in range(len(points)) if i not in way]
            way.append(min(left, key=lambda i: float(away[way[-1], i])))
        way = _uncrossed(way, away)
        length = float(sum(away[a, b] for a, b in pairwise(way)))
        if length < least - 1e-9:
            best, least = way, length
    return np.array(best)


def _uncrossed(way: list[int], away: np.ndarray) -> list[int]:
    """The way with parts reversed where that makes it shorter."""

    def length(path: list[int]) -> float:
        return float(sum(away[a, b] for a, b in pairwise(path)))

    improved = True
    while improved:
        improved = False
        for i in range(len(way)):
            for j in range(i + 2, len(way) + 1):
                turned = way[:i] + way[i:j][::-1] + way[j:]
                if length(turned) < length(way) - 1e-9:
                    way, improved = turned, True
    return way

"""Order along the body: which points are one finger's, in which order from end to end."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree, shortest_path
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
    """The way through points from one end to the other, along the tree of the least length."""
    tree = minimum_spanning_tree(cdist(points, points))
    away = shortest_path(tree, directed=False)
    return np.asarray(away[away.max(axis=0).argmax()].argsort())

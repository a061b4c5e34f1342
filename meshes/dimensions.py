"""Motion of the points of a finger's mesh as its dimensions change; cells and groups stay.

All faces of a bellows finger lie in planes x, y or z = const that follow from its dimensions, so a
mesh of any kind follows a change of a dimension by moving along each axis: the planes go where the
new dimensions put them, and points between two planes keep their relative position.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.finger import TOLERANCE_MM, boxes
from dolfingrip.meshes.solid import Floats, MeshError
from dolfingrip.sections.specimen import Finger


def moved(points: Floats, finger: Finger, changed: Finger) -> Floats:
    """Points of a mesh of ``finger``, moved to the dimensions of ``changed``.

    Args:
        points: (n, 3) before any morph (mm).
        finger: dimensions that the mesh was made from.
        changed: other dimensions with the same number of bellows.

    Returns:
        (n, 3) points (mm).

    Raises:
        MeshError: the two fingers differ in the order of their planes.
    """
    found = points.copy()
    for axis, (before, after) in enumerate(zip(_planes(finger), _planes(changed), strict=True)):
        if len(before) != len(after):
            raise MeshError(
                f"finger.bellows = {changed.bellows}: allowed: {finger.bellows}, the number in "
                "the mesh that is to be moved"
            )
        order = np.argsort(before, kind="stable")
        before, after = before[order], after[order]
        first = np.concatenate([[True], np.diff(before) > TOLERANCE_MM])
        group = np.cumsum(first) - 1
        # planes that coincide in the mesh stay one, at the mean of their new positions
        target = np.bincount(group, after) / np.bincount(group)
        if (np.diff(target) <= 0).any():
            raise MeshError(f"finger: {changed} has its faces in another order; remesh it")
        found[:, axis] = np.interp(points[:, axis], before[first], target)
    return found


def _planes(finger: Finger) -> list[Floats]:
    """Coordinates of the faces along each axis (mm), in an order that the dimensions set."""
    body, cavity, gaps = boxes(finger)
    return [
        np.array([value for box in (body, *cavity, *gaps) for value in box[axis]])
        for axis in range(3)
    ]

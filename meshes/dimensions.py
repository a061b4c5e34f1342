"""How the points of a finger's mesh move as its dimensions change, cells and groups staying.

All faces of a finger of boxes lie in planes x, y or z = const that follow from its dimensions, so a
mesh of any kind follows a change of a dimension by moving along each axis: the planes go where the
new dimensions put them, and what lies between two planes keeps its share of the way.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.boxes import TOLERANCE_MM
from dolfingrip.meshes.kinds import Dimensions, box_solid
from dolfingrip.meshes.solid import Floats, MeshError


def moved(points: Floats, dimensions: Dimensions, changed: Dimensions) -> Floats:
    """Points of a mesh of ``dimensions`` where ``changed`` has them.

    Args:
        points: (n, 3) before any morph (mm).
        dimensions: that the mesh was made from.
        changed: others of the same kind with the same number of chambers.

    Returns:
        (n, 3) points (mm).

    Raises:
        MeshError: the two have not the same planes in the same order.
    """
    found = points.copy()
    solids = box_solid(dimensions), box_solid(changed)
    for axis in range(3):
        before, after = (solid.planes(axis) for solid in solids)
        if len(before) != len(after):
            (_, there), (key, asked) = dimensions.count(), changed.count()
            raise MeshError(
                f"{key} = {asked}: allowed: {there}, the number in the mesh that is to be moved"
            )
        order = np.argsort(before, kind="stable")
        before, after = before[order], after[order]
        first = np.concatenate([[True], np.diff(before) > TOLERANCE_MM])
        group = np.cumsum(first) - 1
        # planes that are one in the mesh stay one, on the average of where they ought to be
        target = np.bincount(group, after) / np.bincount(group)
        if (np.diff(target) <= 0).any():
            raise MeshError(f"finger: {changed} has its faces in another order; mesh it anew")
        found[:, axis] = np.interp(points[:, axis], before[first], target)
    return found

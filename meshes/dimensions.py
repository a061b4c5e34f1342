"""Motion of the points of a finger's mesh as its dimensions change; cells and groups stay.

All faces of a finger of boxes lie in planes x, y or z = const that follow from its dimensions, so a
mesh of any kind follows a change of a dimension by moving along each axis: the planes go where the
new dimensions put them, and points between two planes keep their relative position.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.solid import Floats, MeshError
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry


def moved(points: Floats, dimensions: Geometry, changed: Geometry) -> Floats:
    """Points of a mesh, moved as its dimensions change to others.

    Args:
        points: (n, 3) points (mm) before any morph.
        dimensions: dimensions that the mesh was made from.
        changed: other dimensions of the same kind with the same number of chambers.

    Returns:
        (n, 3) moved points (mm).

    Raises:
        MeshError: one line, if the two fingers differ in the order of their planes.
    """
    found = points.copy()
    solids = [each for each in (dimensions.solid(), changed.solid()) if isinstance(each, BoxSolid)]
    if len(solids) < 2:
        raise MeshError(f"{dimensions.table()}: no mesh of round faces moves; remesh it")
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
        # planes that coincide in the mesh stay one, at the mean of their new positions
        target = np.bincount(group, after) / np.bincount(group)
        if (np.diff(target) <= 0).any():
            raise MeshError(f"finger: {changed} has its faces in another order; remesh it")
        found[:, axis] = np.interp(points[:, axis], before[first], target)
    return found

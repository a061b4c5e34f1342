"""Motion of the points of a finger's mesh as its dimensions change; cells and groups stay.

All faces of a finger of boxes lie in planes x, y or z = const that follow from its dimensions, so a
mesh of any kind follows a change of a dimension by moving along each axis: the planes go where the
new dimensions put them, and points between two planes keep their relative position.

Where chambers have dimensions of their own, the planes across x and y stand elsewhere in each
chamber (:meth:`~dolfingrip.sections.geometry.geometry.Geometry.sections`) and are inclined between
two of them. A mesh of such a finger is that of one with the shared dimensions, moved.

Dimensions that leave almost nothing between two faces are refused.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.meshes.solid import Floats, MeshError
from dolfingrip.sections.geometry.boxes import THINNEST_MM, TOLERANCE_MM, BoxSolid
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
    placed = points.copy()
    solids = [s for s in (dimensions.solid(), changed.solid()) if isinstance(s, BoxSolid)]
    if len(solids) < 2:
        raise MeshError(f"{dimensions.table()}: no mesh of round faces moves; remesh it")
    if len(solids[0].planes(2)) != len(solids[1].planes(2)):
        (_, there), (key, count) = dimensions.count(), changed.count()
        raise MeshError(
            f"{key} = {count}: allowed: {there}, the number in the mesh that is to be moved"
        )
    differ = dimensions.differ or changed.differ
    if differ:
        for axis in range(2):
            placed[:, axis] = _across(points, dimensions, changed, axis)
    for axis in (2,) if differ else range(3):
        before, after = (solid.planes(axis) for solid in solids)
        order = np.argsort(before, kind="stable")
        before, after = before[order], after[order]
        first = np.concatenate([[True], np.diff(before) > TOLERANCE_MM])
        group = np.cumsum(first) - 1
        # planes that coincide in the mesh stay one, at the mean of their new positions
        target = np.bincount(group, after) / np.bincount(group)
        if (np.diff(target) <= 0).any():
            raise MeshError(f"finger: {changed} has its faces in another order; remesh it")
        placed[:, axis] = np.interp(points[:, axis], before[first], target)
    return placed


def _across(points: Floats, dimensions: Geometry, changed: Geometry, axis: int) -> Floats:
    """New coordinates (n,) along x or y, whose planes depend on z."""
    z = np.concatenate([extent for extent, _ in dimensions.sections()])
    at = np.clip(np.searchsorted(z, points[:, 2], side="right") - 1, 0, len(z) - 2)
    length = np.maximum(np.diff(z), TOLERANCE_MM)
    share = np.clip((points[:, 2] - z[at]) / length[at], 0.0, 1.0)[:, None]
    shared = _planes(dimensions.alike(), axis)
    order = np.argsort(shared, kind="stable")
    order = order[np.concatenate([[True], np.diff(shared[order]) > TOLERANCE_MM])]
    planes = []
    for geometry in (dimensions, changed):
        of = np.array([_planes(section, axis)[order] for _, section in geometry.sections()])
        of = np.repeat(of, 2, axis=0)  # at both ends of each
        planes.append((1 - share) * of[at] + share * of[at + 1])
    before, after = planes
    if (np.diff(after, axis=1) <= 0).any():
        raise MeshError(f"finger: {changed} has its faces in another order; remesh it")
    return followed(points[:, axis], before, after)


def followed(x: Floats, before: Floats, after: Floats) -> Floats:
    """Coordinates (n,) as planes move, of which each point has its own.

    Args:
        x: (n,) coordinates.
        before, after: (n, planes) where the planes are and go to, ascending.
    """
    rows = np.arange(len(x))
    below = np.clip((before <= x[:, None]).sum(axis=1) - 1, 0, before.shape[1] - 2)
    low, high = before[rows, below], before[rows, below + 1]
    part = (x - low) / (high - low)
    return np.asarray((1 - part) * after[rows, below] + part * after[rows, below + 1])


def _planes(geometry: Geometry, axis: int) -> Floats:
    boxes = geometry.boxes()
    assert boxes is not None  # the caller sees to it
    return boxes.planes(axis)


def own(geometry: Geometry) -> Callable[[Floats], Floats] | None:
    """Motion of points from a finger with the shared dimensions to one with chambers of their own.

    Args:
        geometry: of the finger.

    Returns:
        A function of (n, 3) points (mm); None where all chambers are alike, or the solid is not of
        boxes and so has each chamber's own dimensions.
    """
    if not geometry.differ or geometry.boxes() is None:
        return None
    return lambda points: moved(points, geometry.alike(), geometry)


def refuse_slivers(geometry: Geometry) -> None:
    """Refuse dimensions that leave faces closer than :data:`THINNEST_MM`.

    Raises:
        MeshError: one line naming the dimension, or where the faces are.
    """
    distances = geometry.distances_mm()
    for key, distance in distances.items():
        if distance < THINNEST_MM:
            raise MeshError(
                f"{geometry.table()}.{key} = {getattr(geometry, key)}: leaves {distance:.3g} mm "
                f"between two faces; allowed: at least {THINNEST_MM} mm"
            )
    solid = geometry.alike().solid()
    if not distances and isinstance(solid, BoxSolid):
        _refuse_near_planes(solid, geometry.table())


def _refuse_near_planes(solid: BoxSolid, table: str) -> None:
    for axis, letter in enumerate("xyz"):
        planes = np.unique(solid.planes(axis))
        apart = np.diff(planes)
        near = (apart > TOLERANCE_MM) & (apart < THINNEST_MM * (1 - 1e-9))
        if near.any():
            at = int(near.argmax())
            raise MeshError(
                f"{table}: leaves {apart[at]:.3g} mm between two faces at {letter} = "
                f"{planes[at]:.4g} mm; allowed: at least {THINNEST_MM} mm"
            )

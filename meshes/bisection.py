"""Bisection: every cell of a mesh becomes eight, by the middles of its edges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from dolfingrip.meshes.cells import TETRAHEDRON, CellShape, Floats, Ints
from dolfingrip.meshes.solid import ON_PLANE, MeshError, SolidMesh, faces, match
from dolfingrip.sections.geometry.boxes import Cylinder

PARTS: Final = 8
"""Parts of a cell."""

_TETRAHEDRA: Final = np.array(
    [
        [[0, 0], [0, 1], [0, 2], [0, 3]],
        [[0, 1], [1, 1], [1, 2], [1, 3]],
        [[0, 2], [1, 2], [2, 2], [2, 3]],
        [[0, 3], [1, 3], [2, 3], [3, 3]],
        [[0, 1], [0, 2], [0, 3], [1, 3]],
        [[0, 1], [0, 2], [1, 3], [1, 2]],
        [[0, 2], [0, 3], [1, 3], [2, 3]],
        [[0, 2], [1, 3], [1, 2], [2, 3]],
    ]
)
"""Corners of a tetrahedron's parts: the middle of two of its corners each. Four are at its corners,
the octahedron between them is cut along one diagonal (Bey, Computing 55, 1995)."""


def corners_of_parts(shape: CellShape) -> Floats:
    """Place the corners of a cell's parts in the cell.

    Args:
        shape: of the cells.

    Returns:
        Reference coordinates, (8, corners, 3), the corners in Gmsh's order.
    """
    if shape is TETRAHEDRON:
        return np.asarray(shape.reference[_TETRAHEDRA].mean(axis=2))
    return (shape.reference[:, None] + shape.reference) / 2


def corner_weights(shape: CellShape, places: Floats) -> Floats:
    """Evaluate the linear shape functions of a cell's corners.

    Args:
        shape: of the cell.
        places: (n, 3) reference coordinates.

    Returns:
        (n, corners) values, the corners in Gmsh's order.
    """
    if shape is TETRAHEDRON:
        return np.column_stack([1 - places.sum(axis=1), places])
    at_one = shape.reference > 0.5
    return np.prod(np.where(at_one, places[:, None], 1 - places[:, None]), axis=2)


def divided(mesh: SolidMesh, refine: int, round_faces: Sequence[Cylinder] = ()) -> SolidMesh:
    """Bisect every cell until it is divided so often along each axis.

    Args:
        mesh: of first order (mm).
        refine: how often; a power of 2.
        round_faces: as those of :func:`bisected`.

    Returns:
        The mesh of the parts; ``mesh`` itself where ``refine`` is 1.

    Raises:
        MeshError: where ``refine`` is no power of 2, or ``mesh`` of second order.
    """
    if refine & (refine - 1):
        raise MeshError(
            f"mesh.refine = {refine}: {mesh.shape.plural}: allowed: 1, 2, 4, 8 or 16, "
            "as each is bisected"
        )
    for _ in range(refine.bit_length() - 1):
        mesh = bisected(mesh, round_faces)
    return mesh


def bisected(mesh: SolidMesh, round_faces: Sequence[Cylinder] = ()) -> SolidMesh:
    """Bisect every cell.

    Args:
        mesh: of first order (mm).
        round_faces: cylinders along z that faces of the solid lie on; new points of such a face
            are moved onto its cylinder.

    Returns:
        The mesh of the parts, with its groups and regions: part ``i`` of cell ``c`` is row
        8 c + i. The points of ``mesh`` come first and keep their numbers.

    Raises:
        MeshError: where the mesh is of second order.
    """
    shape = mesh.shape
    if mesh.order != 1:
        raise MeshError(f"mesh: {shape.plural} of order {mesh.order}; allowed: order 1")
    at = corners_of_parts(shape)
    lattice, which = np.unique(at.reshape(-1, 3), axis=0, return_inverse=True)
    numbers, points, ends = _numbered(mesh, corner_weights(shape, lattice) > 0)
    cells = numbers[:, which.reshape(at.shape[:2])].reshape(-1, shape.corners)
    every, beyond = faces(cells), _faces_of_parts(shape, at)
    facets: dict[str, Ints] = {}
    for name, group in mesh.facets.items():
        cell, face = np.divmod(match(group, mesh.cells), len(shape.faces))
        rows = [
            (PARTS * cell[face == own] + part) * len(shape.faces) + other
            for own, of_parts in enumerate(beyond)
            for part, other in of_parts
        ]
        facets[name] = np.asarray(every[np.concatenate(rows)], dtype=np.int64)
    regions: dict[str, Ints] = {
        name: np.asarray(PARTS * rows[:, None] + np.arange(PARTS), dtype=np.int64).ravel()
        for name, rows in mesh.regions.items()
    }
    for cylinder in round_faces:
        _put_on(cylinder, mesh, ends, points)
    return SolidMesh(points, cells, facets, regions)


def _numbered(mesh: SolidMesh, corners: np.ndarray) -> tuple[Ints, Floats, Ints]:
    """Numbers (cells, n) of each cell's points, and all points, which are middles of ``corners``.

    Cells share a point if it is the middle of the same corners. Points of separate bodies that only
    touch stay apart. The third array has both ends of each edge, (e, 2), in the order of the edges'
    middles, which are the first of the new points.
    """
    numbers = np.empty((len(mesh.cells), len(corners)), dtype=np.int64)
    points, count = [mesh.points], len(mesh.points)
    edges: Ints = np.empty((0, 2), dtype=np.int64)
    for many in np.unique(corners.sum(axis=1)):
        mine = np.flatnonzero(corners.sum(axis=1) == many)
        ends = np.stack([mesh.cells[:, corners[i]] for i in mine], axis=1)
        if many == 1:
            numbers[:, mine] = ends[..., 0]
            continue
        keys, inverse = np.unique(
            np.sort(ends, axis=2).reshape(-1, many), axis=0, return_inverse=True
        )
        numbers[:, mine] = count + inverse.reshape(len(numbers), -1)
        points.append(mesh.points[keys].mean(axis=1))
        count += len(keys)
        edges = keys if many == 2 else edges
    return numbers, np.concatenate(points), edges


def _put_on(cylinder: Cylinder, mesh: SolidMesh, ends: Ints, points: Floats) -> None:
    """Move the middles of the edges of a cylinder's faces onto it."""
    axis = np.array([cylinder.axis_mm, 0.0])
    radius = np.linalg.norm(mesh.points[:, :2] - axis, axis=1)
    z, near = mesh.points[:, 2], ON_PLANE * cylinder.radius_mm
    low, high = cylinder.along_mm
    on = (np.abs(radius - cylinder.radius_mm) < near) & (z > low - near) & (z < high + near)
    facets = np.concatenate(list(mesh.facets.values()))
    # facets of the cylinder's ends are flat
    facets = facets[on[facets].all(axis=1) & (np.ptp(z[facets], axis=1) > near)]
    edges = np.sort(np.stack([facets, np.roll(facets, 1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    count = len(points)
    mine = len(mesh.points) + np.flatnonzero(np.isin(ends @ [count, 1], edges @ [count, 1]))
    off = points[mine, :2] - axis
    points[mine, :2] = axis + off * (cylinder.radius_mm / np.linalg.norm(off, axis=1))[:, None]


def _faces_of_parts(shape: CellShape, at: Floats) -> list[list[tuple[int, int]]]:
    """Parts, and faces of these, that lie in each face of a cell."""
    found = []
    for corners in shape.face_corners:
        start, one, other = shape.reference[corners[:3]]
        off = np.abs((at - start) @ np.cross(one - start, other - start)) < 1e-9
        found.append([
            (part, face)
            for part in range(PARTS)
            for face, own in enumerate(shape.face_corners)
            if off[part, own].all()
        ])  # fmt: skip
    return found

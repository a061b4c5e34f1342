"""Bisection: every cell of a mesh becomes eight, by the middles of its edges."""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.meshes.cells import TETRAHEDRON, CellShape, Floats, Ints, of_cell
from dolfingrip.meshes.rounding import CurvedFaces
from dolfingrip.meshes.solid import MeshError, SolidMesh, faces, match

PARTS: Final = 8
"""Parts of a cell."""

NEAR: Final = 1e-9
"""Value of a corner's shape function above which it is felt, and distance from a face below which a
place lies in it, in reference coordinates."""

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


def divided(mesh: SolidMesh, refine: int) -> SolidMesh:
    """Bisect every cell until it is divided so often along each axis.

    Args:
        mesh: of first order (mm).
        refine: how often; a power of 2.

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
        mesh = bisected(mesh)
    return mesh


def bisected(mesh: SolidMesh) -> SolidMesh:
    """Bisect every cell; new points of curved faces are moved onto them.

    Args:
        mesh: of first order (mm).

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
    numbers, points = _numbered(mesh, of_cell(shape.corners).values(lattice) > NEAR)
    cells = numbers[:, which.reshape(at.shape[:2])].reshape(-1, shape.corners)
    every, beyond = faces(cells), _faces_of_parts(shape, at)
    facets: dict[str, Ints] = {}
    for name, group in mesh.facets.items():
        cell, face = np.divmod(match(group, mesh.cells), len(shape.faces))
        rows = [
            (PARTS * cell[face == side] + part) * len(shape.faces) + other
            for side, of_parts in enumerate(beyond)
            for part, other in of_parts
        ]
        facets[name] = np.asarray(every[np.concatenate(rows)], dtype=np.int64)
    regions: dict[str, Ints] = {
        name: np.asarray(PARTS * rows[:, None] + np.arange(PARTS), dtype=np.int64).ravel()
        for name, rows in mesh.regions.items()
    }
    return SolidMesh(points, cells, facets, regions)


def _numbered(mesh: SolidMesh, corners: np.ndarray) -> tuple[Ints, Floats]:
    """Numbers (cells, n) of each cell's points, and all points, which are middles of ``corners``.

    Cells share a point if it is the middle of the same corners. Points of separate bodies that only
    touch stay apart.
    """
    numbers = np.empty((len(mesh.cells), len(corners)), dtype=np.int64)
    points, count = [mesh.points], len(mesh.points)
    curved = CurvedFaces(mesh)
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
        points.append(mesh.points[keys].mean(axis=1) + curved.off(keys))
        count += len(keys)
    return numbers, np.concatenate(points)


def _faces_of_parts(shape: CellShape, at: Floats) -> list[list[tuple[int, int]]]:
    """Parts, and faces of these, that lie in each face of a cell."""
    by_face = []
    for corners in shape.face_corners:
        start, one, other = shape.reference[corners[:3]]
        off = np.abs((at - start) @ np.cross(one - start, other - start)) < NEAR
        by_face.append([
            (part, face)
            for part in range(PARTS)
            for face, nodes in enumerate(shape.face_corners)
            if off[part, nodes].all()
        ])  # fmt: skip
    return by_face

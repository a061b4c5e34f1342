"""A whole finger cut open: its mesh is sawn along the finger's mid plane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyvista as pv

from dolfingrip.meshes.cells import BY_NODES
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.skin import Floats, mid_plane

SMALL = 1e-6
"""Distance from the plane, by the finger's size, within which a node lies in it."""


def sawn(
    mesh: FieldMesh, fields: Sequence[Floats], sides: Sequence[int] = (1,)
) -> tuple[FieldMesh, list[Floats], Floats]:
    """Saw a mesh along the finger's mid plane, a plane of constant y.

    Elements that the plane goes through are divided into tetrahedra of their corners.

    Args:
        mesh: of a whole finger, or of several side by side.
        fields: each with values at the nodes, shape (nodes,) or (nodes, 3).
        sides: that are kept: 1 where y is larger than in the plane, -1 where it is smaller.

    Returns:
        The mesh, whose sides share no nodes; the fields at its nodes; and the side of each node.
    """
    plane = mid_plane(mesh.points)
    small = SMALL * float(np.ptp(mesh.points, axis=0).max())
    shape = BY_NODES[min(mesh.cells.shape[1], 20)]
    away = mesh.points[mesh.cells[:, : shape.corners], 1] - plane
    if ((away.min(axis=1) < -small) & (away.max(axis=1) > small)).any():
        kind = pv.CellType.TETRA if shape.corners == 4 else pv.CellType.HEXAHEDRON
        corners = mesh.cells[:, : shape.corners]
        grid: pv.UnstructuredGrid = pv.UnstructuredGrid({kind: corners}, mesh.points)
        for number, field in enumerate(fields):
            grid[str(number)] = field
        at = (0.0, plane, 0.0)
        halves = [grid.clip("y", origin=at, invert=flip).triangulate() for flip in (True, False)]
        grid = pv.merge(halves, merge_points=False)
        cells = np.asarray(grid.cells, dtype=np.int64).reshape(-1, 5)[:, 1:]  # tetrahedra alone
        points = np.asarray(grid.points, dtype=float)
        fields = [np.asarray(grid[str(number)], dtype=float) for number in range(len(fields))]
        mesh = FieldMesh(points, cells, np.arange(len(points)))
        away = points[cells, 1] - plane
    kept = [mesh.cells[side * away.mean(axis=1) > 0] for side in sides]
    nodes = [np.unique(cells) for cells in kept]
    starts = np.cumsum([0, *map(len, nodes)])
    cells = np.concatenate(
        [np.searchsorted(n, c) + start for n, c, start in zip(nodes, kept, starts, strict=False)]
    )
    node = np.concatenate(nodes)
    opened = FieldMesh(mesh.points[node], cells, mesh.source[node])
    side = np.repeat(np.array(sides, dtype=float), np.diff(starts))
    return opened, [field[node] for field in fields], side

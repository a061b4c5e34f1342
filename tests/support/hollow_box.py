"""Half of a box of hexahedra with a hollow that ends on the plane y = 0."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.cells import HEXAHEDRON
from dolfingrip.meshes.solid import SolidMesh, assemble, boundary, faces, second_order

STEP_MM = np.array([2.0, 1.5, 3.0])
CELLS = (4, 3, 5)
HOLLOW = ((1, 3), (0, 2), (1, 4))
"""Cells that are missing, from and to along each axis."""

VOLUME_MM3 = float(STEP_MM.prod() * (4 * 3 * 5 - 2 * 2 * 3))
CAVITY_MM3 = float(STEP_MM.prod() * 2 * 2 * 3)


def mesh(order: int = 1) -> SolidMesh:
    """Hexahedra of first or second order, with the groups of a half finger."""
    index = np.arange(np.prod([n + 1 for n in CELLS])).reshape([n + 1 for n in CELLS])
    points = np.argwhere(index >= 0) * STEP_MM
    at = np.argwhere(np.ones(CELLS, dtype=bool))
    inside = [(at[:, i] >= low) & (at[:, i] < high) for i, (low, high) in enumerate(HOLLOW)]
    at = at[~np.all(inside, axis=0)]
    corners = HEXAHEDRON.reference.astype(int)
    cells = np.column_stack([index[tuple((at + corner).T)] for corner in corners])
    outer = faces(cells)[boundary(cells)]
    middle = points[outer].mean(axis=1)
    size = STEP_MM * CELLS
    groups = {
        "clamp": middle[:, 2] < 1e-9,
        "tip": middle[:, 2] > size[2] - 1e-9,
        "symmetry": middle[:, 1] < 1e-9,
        "skin": (np.abs(middle[:, 0] - size[0] / 2) > size[0] / 2 - 1e-9)
        | (middle[:, 1] > size[1] - 1e-9),
    }
    groups["cavity"] = ~np.any(list(groups.values()), axis=0)
    found = assemble(points, cells, {name: outer[where] for name, where in groups.items()})
    return found if order == 1 else second_order(found)

"""The tip's mean displacement from nodal values: what all programs are compared by."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.groups import TIP
from dolfingrip.meshes.solid import SolidMesh


def mean_displacement(mesh: SolidMesh, displacement: np.ndarray) -> np.ndarray:
    """(3,) mean over the tip face's area (mm), as ``tip_x_mm`` and ``tip_z_mm`` are.

    Args:
        mesh: straight-sided, of first or second order.
        displacement: (n, 3) at the mesh's points, mm; only those of the tip are used.
    """
    facets = mesh.facets[TIP]
    a, b, c = (mesh.points[facets[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    # shape functions of a quadratic triangle integrate to 0 at corners, 1/3 at midpoints
    nodes = facets[:, :3] if mesh.order == 1 else facets[:, 3:]
    mean: np.ndarray = area @ displacement[nodes].mean(axis=1) / area.sum()
    return mean

"""Copies of a solid in one mesh."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.solid import SolidMesh

APART: float = 0.5
"""Space between copies, as a part of a solid's depth."""


def side_by_side(solid: SolidMesh, count: int) -> SolidMesh:
    """So many copies, each shifted along x from the last by 1 + :data:`APART` of its depth.

    They share no node; a surface group has the facets of all.
    """
    size = len(solid.points)
    shift = np.array([(1 + APART) * float(np.ptp(solid.points[:, 0])), 0.0, 0.0])
    points = np.concatenate([solid.points + i * shift for i in range(count)])
    cells = np.concatenate([solid.cells + i * size for i in range(count)])
    facets = {
        name: np.concatenate([found + i * size for i in range(count)])
        for name, found in solid.facets.items()
    }
    return SolidMesh(points, cells, facets)


def shares(low_mm: float, high_mm: float, count: int) -> tuple[float, float]:
    """Shift from one of so many copies to the next, and where the first one's share of x starts.

    Args:
        low_mm: least x of all copies together.
        high_mm: largest one.
        count: of the copies.
    """
    depth = (high_mm - low_mm) / (1 + (count - 1) * (1 + APART))
    return (1 + APART) * depth, low_mm - APART / 2 * depth

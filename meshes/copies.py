"""Copies of a solid in one mesh."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.solid import SolidMesh

APART: float = 0.5
"""Space between copies, as a part of a solid's depth."""


def pitch_mm(solid: SolidMesh) -> float:
    """Shift along x from one copy to the next."""
    return (1 + APART) * float(np.ptp(solid.points[:, 0]))


def side_by_side(solid: SolidMesh, count: int) -> SolidMesh:
    """So many copies, each shifted along x by :func:`pitch_mm` from the last.

    They share no node; a surface group has the facets of all.
    """
    size = len(solid.points)
    shift = np.array([pitch_mm(solid), 0.0, 0.0])
    points = np.concatenate([solid.points + i * shift for i in range(count)])
    cells = np.concatenate([solid.cells + i * size for i in range(count)])
    facets = {
        name: np.concatenate([found + i * size for i in range(count)])
        for name, found in solid.facets.items()
    }
    return SolidMesh(points, cells, facets)

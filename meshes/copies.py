"""Copies of a solid in one mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dolfingrip.meshes.solid import Ints, SolidMesh

APART: float = 0.5
"""Space between copies, as a part of a solid's depth."""


def side_by_side(solids: Sequence[SolidMesh]) -> SolidMesh:
    """Solids of one depth, each shifted along x from the last by 1 + :data:`APART` of it.

    They share no node; a surface group has the facets of all that have it.
    """
    shift = np.array([(1 + APART) * float(np.ptp(solids[0].points[:, 0])), 0.0, 0.0])
    first = np.cumsum([0, *(len(solid.points) for solid in solids)])
    points = np.concatenate([solid.points + i * shift for i, solid in enumerate(solids)])
    cells = np.concatenate([s.cells + start for s, start in zip(solids, first, strict=False)])
    facets: dict[str, list[Ints]] = {}
    for solid, start in zip(solids, first, strict=False):
        for name, found in solid.facets.items():
            facets.setdefault(name, []).append(found + start)
    joined = {name: np.concatenate(found) for name, found in facets.items()}
    return SolidMesh(points, cells, joined)


def shares(low_mm: float, high_mm: float, count: int) -> tuple[float, float]:
    """Shift from one of so many copies to the next, and where the first one's share of x starts.

    Args:
        low_mm: least x of all copies together.
        high_mm: largest one.
        count: of the copies.
    """
    depth = (high_mm - low_mm) / (1 + (count - 1) * (1 + APART))
    return (1 + APART) * depth, low_mm - APART / 2 * depth

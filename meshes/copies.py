"""Several solids in one mesh, without shared nodes: in place, or as copies side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from dolfingrip.meshes.solid import Ints, MeshError, SolidMesh

APART: float = 0.5
"""Space between copies, as a part of the solid's depth."""


def merged(solids: Sequence[SolidMesh]) -> SolidMesh:
    """Solids that share no node, as one mesh.

    A surface group has the facets of all solids that have it. A region has their cells.

    Raises:
        MeshError: one line, if their elements differ.
    """
    kinds = [f"{solid.shape.plural} of order {solid.order}" for solid in solids]
    if len(set(kinds)) > 1:
        raise MeshError(f"solids: {', '.join(kinds)}; allowed: elements of one shape and order")
    counts = [len(solid.points) for solid in solids]
    first = np.cumsum([0, *counts])
    points = np.concatenate([solid.points for solid in solids])
    cells = np.concatenate([s.cells + start for s, start in zip(solids, first, strict=False)])
    facets = all_rows([s.facets for s in solids], counts)
    regions = all_rows([s.regions for s in solids], [len(s.cells) for s in solids])
    return SolidMesh(points, cells, facets, regions)


def side_by_side(solids: Sequence[SolidMesh]) -> SolidMesh:
    """Put several solids into one mesh.

    Args:
        solids: meshes of one depth (mm).

    Returns:
        One mesh; each solid is shifted along x by 1 + :data:`APART` depths from the one
        before.
    """
    shift = np.array([(1 + APART) * float(np.ptp(solids[0].points[:, 0])), 0.0, 0.0])
    shifted = [replace(solid, points=solid.points + i * shift) for i, solid in enumerate(solids)]
    return merged(shifted)


def all_rows(each: Sequence[Mapping[str, Ints]], counts: Sequence[int]) -> dict[str, Ints]:
    """Rows of each name in all solids, which are put one after the other.

    Args:
        each: for each solid, rows of its points, cells or faces of cells, by name.
        counts: number of these in each solid.
    """
    found: dict[str, list[Ints]] = {}
    for rows, start in zip(each, np.cumsum([0, *counts]), strict=False):
        for name, own in rows.items():
            found.setdefault(name, []).append(own + start)
    return {name: np.concatenate(rows) for name, rows in found.items()}


def shares(low_mm: float, high_mm: float, count: int) -> tuple[float, float]:
    """Shift from one copy to the next, and the x at which the first copy's share begins.

    Args:
        low_mm: smallest x of all copies.
        high_mm: largest x of all copies.
        count: number of copies.
    """
    depth = (high_mm - low_mm) / (1 + (count - 1) * (1 + APART))
    return (1 + APART) * depth, low_mm - APART / 2 * depth

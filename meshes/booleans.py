"""Solids in the OpenCASCADE kernel: bricks, tapered bricks, and their unions and differences."""

from __future__ import annotations

import gmsh

from dolfingrip.sections.geometry.boxes import Box

Solids = list[tuple[int, int]]
"""Volumes of the current Gmsh model: their dimension, 3, and their tags."""


def brick(box: Box) -> Solids:
    """Add a box to the current Gmsh model.

    Args:
        box: extent along x, y and z (mm).
    """
    sizes = (high - low for low, high in box)
    return [(3, gmsh.model.occ.addBox(*(low for low, _ in box), *sizes))]


def tapered(box: Box, axis: int, root: int, slope: float) -> Solids:
    """Add a box to the current Gmsh model whose section shrinks along an axis.

    Half way it has the box's section.

    Args:
        box: extent along x, y and z (mm).
        axis: along which it is pulled.
        root: end of the axis with the largest section, 0 the lower one, 1 the upper one.
        slope: tangent of the angle of its sides.
    """
    sides = [each for each in range(3) if each != axis]
    by = slope * (box[axis][1] - box[axis][0]) / 2
    wires = []
    for end, at in enumerate(box[axis]):
        more = by if end == root else -by
        low, high = ([box[side][i] + (more if i else -more) for side in sides] for i in (0, 1))
        corners = []
        for u, v in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])):
            place = dict(zip((axis, *sides), (at, u, v), strict=True))
            corners.append(gmsh.model.occ.addPoint(place[0], place[1], place[2]))
        ends = zip(corners, corners[1:] + corners[:1], strict=True)
        wires.append(gmsh.model.occ.addWire([gmsh.model.occ.addLine(a, b) for a, b in ends]))
    return list(gmsh.model.occ.addThruSections(wires, makeSolid=True, makeRuled=True))


def fused(first: Solids, others: Solids) -> Solids:
    """Unite solids.

    Args:
        first, others: the solids, which are used up.
    """
    return list(gmsh.model.occ.fuse(first, others)[0]) if others else first


def less(solid: Solids, tools: Solids, *, keep: bool = False) -> Solids:
    """Take tools away from a solid.

    Args:
        solid: it is used up.
        tools: what is taken away.
        keep: whether the tools stay; they are used up otherwise.
    """
    return list(gmsh.model.occ.cut(solid, tools, removeTool=not keep)[0]) if tools else solid


def common(solid: Solids, other: Solids) -> Solids:
    """Keep what a solid shares with another one.

    Args:
        solid: it is used up.
        other: it stays.
    """
    return list(gmsh.model.occ.intersect(solid, other, removeTool=False)[0])


def volume_mm3(solids: Solids) -> float:
    """Return the volume of solids of the current Gmsh model.

    Args:
        solids: dimension and tag of each.
    """
    return sum(float(gmsh.model.occ.getMass(*each)) for each in solids)

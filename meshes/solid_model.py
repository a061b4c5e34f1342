"""A solid of boxes, or of cylinders and blocks, in the OpenCASCADE kernel."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import gmsh
import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.dimensions import own, refuse_slivers
from dolfingrip.meshes.gmsh_model import fused, less
from dolfingrip.meshes.solid import Floats, MeshError
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, Box, BoxSolid, Cylinder, CylinderSolid
from dolfingrip.sections.geometry.geometry import Geometry


def build(finger: Geometry, half: bool) -> None:
    """Add the finger to the current Gmsh model, with its physical groups.

    Args:
        finger: dimensions.
        half: only y >= 0, with the group ``symmetry`` on y = 0.

    Raises:
        MeshError: if a part of the finger is too thin to be modelled.
    """
    refuse_slivers(finger)
    _add_groups(add_finger(finger, half), finger, half)


def add_solid(shape: BoxSolid | CylinderSolid, half: bool) -> int:
    """Add a block with its hollows to the current Gmsh model; the volume's tag.

    Args:
        shape: the block.
        half: only y >= 0.

    Raises:
        MeshError: if it falls into parts.
    """
    if isinstance(shape, CylinderSolid):
        return _whole(_of_cylinders(shape, half))
    return _whole(_of_boxes(shape, half, lambda box: [_add_box(box, half)]))


def add_finger(
    finger: Geometry, half: bool, place: Callable[[Floats], Floats] = lambda points: points
) -> int:
    """Add a finger, whose chambers may have dimensions of their own; the volume's tag.

    Args:
        finger: dimensions.
        half: only y >= 0.
        place: moves points (n, 3) of chambers of their own (mm), and keeps edges straight.

    Raises:
        MeshError: if it falls into parts.
    """
    boxes, of_own = finger.boxes(), own(finger)
    if boxes is None or of_own is None:
        return add_solid(finger.solid(), half)
    levels = [z for ends, _ in finger.alike().sections() for z in ends]

    def moved(points: Floats) -> Floats:
        return place(of_own(points))

    return _whole(_of_boxes(boxes, half, lambda box: _add_frusta(box, half, moved, levels)))


def _whole(solid: list[tuple[int, int]]) -> int:
    gmsh.model.occ.synchronize()
    if len(solid) != 1:
        raise MeshError(f"finger: falls into {len(solid)} parts; allowed: one solid")
    return int(solid[0][1])


def _add_box(box: Box, half: bool) -> tuple[int, int]:
    x, (y0, y1), z = box
    y0 = 0.0 if half else y0
    return 3, gmsh.model.occ.addBox(x[0], y0, z[0], x[1] - x[0], y1 - y0, z[1] - z[0])


def _add_frusta(
    box: Box, half: bool, place: Callable[[Floats], Floats], levels: Sequence[float]
) -> list[tuple[int, int]]:
    """Add a box whose corners are moved, in pieces between levels."""
    (x0, x1), (y0, y1), (start, end) = box
    y0 = 0.0 if half else y0
    inside = {z for z in levels if start + TOLERANCE_MM < z < end - TOLERANCE_MM}
    rings = []
    for z in (start, *sorted(inside), end):
        ring = place(np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]))
        points = [gmsh.model.occ.addPoint(*point) for point in ring]
        lines = [gmsh.model.occ.addLine(a, b) for a, b in pairwise([*points, points[0]])]
        rings.append(gmsh.model.occ.addWire(lines))
    solids = []
    for pair in pairwise(rings):
        solids += gmsh.model.occ.addThruSections(pair, makeSolid=True, makeRuled=True)
    return [solid for solid in solids if solid[0] == 3]


def _of_boxes(
    boxes: BoxSolid, half: bool, add: Callable[[Box], list[tuple[int, int]]]
) -> list[tuple[int, int]]:
    """Add the body without its gaps and its cavity."""
    channel, *chambers = (part for box in boxes.cavity for part in add(box))
    # The cavity is united before the cut. Its coplanar faces become one; they would divide the
    # mesh otherwise.
    cavity = fused([channel], chambers)
    gaps = [part for box in boxes.gaps for part in add(box)]
    first, *others = add(boxes.body)
    return less(fused([first], others), [*gaps, *cavity])


def _of_cylinders(shape: CylinderSolid, half: bool) -> list[tuple[int, int]]:
    """Add blocks and cylinders without the cavities."""

    def add(cylinder: Cylinder) -> tuple[int, int]:
        start, end = cylinder.along_mm
        # half a cylinder about z lies at y >= 0
        angle = math.pi if half else 2 * math.pi
        return 3, gmsh.model.occ.addCylinder(
            cylinder.axis_mm, 0.0, start, 0.0, 0.0, end - start, cylinder.radius_mm, angle=angle
        )

    hollows = [
        fused([add(first)], [add(cylinder) for cylinder in others])
        for first, *others in shape.cavities
    ]
    first, *others = (_add_box(box, half) for box in shape.blocks)
    body = fused([first], [*others, *(add(cylinder) for cylinder in shape.cylinders)])
    return less(body, [part for hollow in hollows for part in hollow])


def _add_groups(volume: int, finger: Geometry, half: bool) -> None:
    """Make physical groups of the volume and its surfaces."""
    surfaces = [tag for _, tag in gmsh.model.getBoundary([(3, volume)], oriented=False)]
    named = {
        groups.CLAMP: [s for s in surfaces if _lies_in(s, 2, 0.0)],
        groups.TIP: [s for s in surfaces if _lies_in(s, 2, finger.length_mm)],
        groups.SYMMETRY: [s for s in surfaces if half and _lies_in(s, 1, 0.0)],
    }
    # a cavity with a tube and the skin meet at the clamp alone
    walls = set(surfaces) - set(named[groups.SYMMETRY]) - set(named[groups.CLAMP])
    outside = _connected(named[groups.TIP][0], walls)
    named |= _cavities(walls - outside)
    named[groups.SKIN] = sorted(outside - set(named[groups.TIP]))
    gmsh.model.addPhysicalGroup(3, [volume], groups.SOLID_TAG, groups.SOLID)
    for name in groups.surfaces(named):
        if named[name]:
            gmsh.model.addPhysicalGroup(2, named[name], groups.surface_tag(name), name)


def _cavities(walls: set[int]) -> dict[str, list[int]]:
    """The surfaces of each cavity by its name, the one farthest from the contact face first."""
    cavities = []
    while walls:
        joined = _connected(min(walls), walls)
        walls = walls - joined
        cavities.append(sorted(joined))
    cavities.sort(key=lambda cavity: -min(gmsh.model.getBoundingBox(2, tag)[0] for tag in cavity))
    return dict(zip(groups.cavity_names(len(cavities)), cavities, strict=True))


def _lies_in(surface: int, axis: int, value: float) -> bool:
    """Return whether a surface lies in the plane where coordinate ``axis`` has ``value`` (mm)."""
    bounds = gmsh.model.getBoundingBox(2, surface)
    return all(abs(bounds[i] - value) < TOLERANCE_MM for i in (axis, axis + 3))


def _connected(start: int, surfaces: set[int]) -> set[int]:
    """The surfaces that a path over shared edges joins to ``start``."""
    of_curve: dict[int, list[int]] = {}
    curves = {
        s: [tag for _, tag in gmsh.model.getBoundary([(2, s)], oriented=False)] for s in surfaces
    }
    for surface, tags in curves.items():
        for tag in tags:
            of_curve.setdefault(tag, []).append(surface)
    reached, todo = {start}, [start]
    while todo:
        for curve in curves[todo.pop()]:
            new = [s for s in of_curve[curve] if s not in reached]
            reached.update(new)
            todo += new
    return reached

"""The bellows finger as a solid of the OpenCASCADE kernel, built from boxes.

The base layer's back is the plane x = 0, the clamp z = 0, the symmetry plane y = 0.
"""

from __future__ import annotations

import gmsh

from dolfingrip.config import Finger
from dolfingrip.meshes import groups
from dolfingrip.meshes.solid import MeshError

_TOLERANCE_MM = 1e-5
"""Larger than the padding of OpenCASCADE's bounding boxes, smaller than any dimension."""

THINNEST_MM = 0.01
"""Least distance of two parallel faces; the kernel may drop what is much thinner."""

Interval = tuple[float, float]
Box = tuple[Interval, Interval, Interval]
"""Extent (mm) along x, y and z."""


def bellows_intervals(finger: Finger) -> list[tuple[float, float]]:
    """Outer extent along z (mm) of each bellows, from clamp to tip.

    The first bellows adjoins the base block; a gap follows each bellows.
    """
    starts = (finger.base_block_mm + i * finger.pitch_mm for i in range(finger.bellows))
    return [(start, start + finger.bellows_mm) for start in starts]


def gap_intervals(finger: Finger) -> list[tuple[float, float]]:
    """Extent along z (mm) of the clear spaces that the bellows leave between base and tip."""
    bellows = bellows_intervals(finger)
    ends = [finger.base_block_mm, *(end for _, end in bellows)]
    starts = [*(start for start, _ in bellows), finger.length_mm - finger.tip_mm]
    pairs = zip(ends, starts, strict=True)
    return [(end, start) for end, start in pairs if start - end > _TOLERANCE_MM]


def boxes(finger: Finger) -> tuple[Box, list[Box], list[Box]]:
    """The finger's body, its cavity (chambers and channel) and the gaps between its bellows.

    Returns
    -------
    tuple
        The body; the cavity's boxes, which overlap; the gaps. A box is its extent (mm) along
        x, y and z.
    """
    floor, wall, depth = finger.base_layer_mm, finger.wall_mm, finger.depth_mm
    roof = floor + finger.channel_mm
    bellows = bellows_intervals(finger)
    ends = (bellows[0][0] + wall, bellows[-1][1] - wall)
    across = (-finger.width_mm / 2, finger.width_mm / 2)
    chamber = (-finger.chamber_width_mm / 2, finger.chamber_width_mm / 2)
    channel = (-finger.channel_width / 2, finger.channel_width / 2)
    cavity = [
        ((floor, depth - wall), chamber, (start + wall, end - wall)) for start, end in bellows
    ]
    return (
        ((0.0, depth), across, (0.0, finger.length_mm)),
        [((floor, roof), channel, ends), *cavity],
        [((roof + wall, depth), across, z) for z in gap_intervals(finger)],
    )


def build(finger: Finger, half: bool) -> None:
    """Add the finger to the current Gmsh model, with its physical groups.

    Parameters
    ----------
    finger
        Dimensions.
    half
        Only y >= 0, with the group ``symmetry`` on y = 0.

    Raises
    ------
    MeshError
        Where a part of the finger is too thin to be modelled.
    """
    refuse_slivers(finger)

    def add(box: Box) -> tuple[int, int]:
        x, (y0, y1), z = box
        y0 = 0.0 if half else y0
        return 3, gmsh.model.occ.addBox(x[0], y0, z[0], x[1] - x[0], y1 - y0, z[1] - z[0])

    body, hollow, between = boxes(finger)
    channel, *chambers = map(add, hollow)
    # one cavity before the cut: its coplanar faces are united, which the mesh would else feel
    cavity, _ = gmsh.model.occ.fuse([channel], chambers)
    solid, _ = gmsh.model.occ.cut([add(body)], [*map(add, between), *cavity])
    gmsh.model.occ.synchronize()
    if len(solid) != 1:
        raise MeshError(f"finger: falls into {len(solid)} parts; allowed: one solid")
    _add_groups(solid[0][1], finger, half)


def refuse_slivers(finger: Finger) -> None:
    """Faces closer than the kernel can tell apart are no geometry."""
    beside = finger.chamber_width_mm - finger.channel_width
    distances = {
        "length_mm": finger.length_mm,
        "base_block_mm": finger.base_block_mm,
        "tip_mm": finger.tip_mm,
        "base_layer_mm": finger.base_layer_mm,
        "gap_mm": finger.gap_mm,
        "channel_width_mm": min(finger.channel_width, beside or finger.channel_width),
        "channel_mm": min(
            finger.channel_mm,
            finger.depth_mm - finger.base_layer_mm - finger.channel_mm - finger.wall_mm,
        ),
        "wall_mm": min(
            finger.wall_mm, finger.bellows_mm - 2 * finger.wall_mm, finger.chamber_width_mm
        ),
    }
    for key, distance in distances.items():
        if distance < THINNEST_MM:
            raise MeshError(
                f"finger.{key} = {getattr(finger, key)}: leaves {distance:.3g} mm between two "
                f"faces; allowed: at least {THINNEST_MM} mm"
            )


def _add_groups(volume: int, finger: Finger, half: bool) -> None:
    """Physical groups of the volume and its surfaces."""
    surfaces = [tag for _, tag in gmsh.model.getBoundary([(3, volume)], oriented=False)]
    named = {
        groups.CLAMP: [s for s in surfaces if _lies_in(s, 2, 0.0)],
        groups.TIP: [s for s in surfaces if _lies_in(s, 2, finger.length_mm)],
        groups.SYMMETRY: [s for s in surfaces if half and _lies_in(s, 1, 0.0)],
    }
    walls = set(surfaces) - set(named[groups.SYMMETRY])
    outside = _connected(named[groups.CLAMP][0], walls)
    named[groups.CAVITY] = sorted(walls - outside)
    named[groups.SKIN] = sorted(outside - set(named[groups.CLAMP]) - set(named[groups.TIP]))
    gmsh.model.addPhysicalGroup(3, [volume], groups.SOLID_TAG, groups.SOLID)
    for name, tag in groups.SURFACE_TAGS.items():
        if named[name]:
            gmsh.model.addPhysicalGroup(2, named[name], tag, name)


def _lies_in(surface: int, axis: int, value: float) -> bool:
    """Whether a surface lies in the plane where coordinate ``axis`` has ``value`` (mm)."""
    bounds = gmsh.model.getBoundingBox(2, surface)
    return all(abs(bounds[i] - value) < _TOLERANCE_MM for i in (axis, axis + 3))


def _connected(start: int, surfaces: set[int]) -> set[int]:
    """Those of ``surfaces`` that a path over shared edges joins to ``start``."""
    of_curve: dict[int, list[int]] = {}
    curves = {
        s: [tag for _, tag in gmsh.model.getBoundary([(2, s)], oriented=False)] for s in surfaces
    }
    for surface, tags in curves.items():
        for tag in tags:
            of_curve.setdefault(tag, []).append(surface)
    found, todo = {start}, [start]
    while todo:
        for curve in curves[todo.pop()]:
            new = [s for s in of_curve[curve] if s not in found]
            found.update(new)
            todo += new
    return found

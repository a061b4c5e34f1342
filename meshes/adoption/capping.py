"""Caps on openings of a surface of triangles.

A cap fills the passage behind an opening, from its rim to a plane further in. The passage's
triangles go, the cap's outer side closes the rim, and its inner side closes the cut in that plane.
Everything else stays as it was, and the surface is closed again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from dolfingrip.meshes.adoption.hollows import Opening
from dolfingrip.meshes.adoption.roles import Roles
from dolfingrip.meshes.adoption.sound import place
from dolfingrip.meshes.adoption.surface import Faces
from dolfingrip.meshes.solid import Floats, Ints, MeshError, parts_of

THICKNESS: Final = (1.0, 0.7, 0.5, 0.35, 0.25)
"""Thicknesses that are tried, by the one that is asked for."""

ABOUT: Final = (1.0, 0.98, 1.02, 0.96, 1.04, 0.94, 1.06, 0.92, 1.08)
"""Depths that are as good as the one that is tried, by that one."""

MISS: Final = 2e-3
"""Distance of the cap's plane from all corners, by its depth, below which cutting there leaves
slivers."""

WIDENS: Final = 1.5
"""Area of a cap's inner side by the opening's, up to which a passage is even."""


def capped(roles: Roles, cap_mm: float) -> Roles:
    """These roles of the part with its openings away from the clamp closed.

    Args:
        roles: with openings in ``caps``.
        cap_mm: thickness of a cap; it is thinner where no even passage is as deep.

    Raises:
        MeshError: one line, if an opening cannot be closed.
    """
    thinnest = cap_mm
    for opening in roles.caps:
        for share in THICKNESS:
            closed = _closed(roles, opening, share * cap_mm)
            if closed is not None:
                roles, thinnest = closed, min(thinnest, share * cap_mm)
                break
        else:
            raise MeshError(
                f"the opening at {place(opening.centre_mm)} cannot be closed by a cap of "
                f"{cap_mm:.3g} mm or less, as no even passage lies behind it; allowed: another "
                "thickness (--cap-mm), the clamp there (--clamp), or a part that is closed there"
            )
    if not roles.caps:
        return roles
    said = {**roles.said, "cap": f"{roles.said['cap']}; {thinnest:.3g} mm thick (--cap-mm)"}
    return replace(roles, caps=[], said=said)


def _closed(roles: Roles, opening: Opening, cap_mm: float) -> Roles | None:
    """The roles with one opening closed; None if the passage behind it is not even so far in."""
    surface = roles.surface
    normal = roles.rotation @ opening.normal
    height = surface.points @ normal
    cavity = roles.groups[_beyond(surface, opening)]
    passage = _passage(surface, roles.groups == cavity, opening, height, cap_mm)
    if passage is None:
        return None
    rows, height = passage
    points, below, cut = _cut_off(surface, rows, height)
    kept = np.setdiff1d(np.arange(len(surface.triangles)), rows)
    parts = [
        (surface.triangles[kept], surface.face[kept], roles.groups[kept]),
        (below.triangles, below.face, np.full(len(below.face), cavity)),
    ]
    new = len(surface.face_areas)
    outside = roles.groups[surface.face == opening.face][0]
    sides = (
        (opening.rim, opening.face if opening.flat else new, outside, normal),
        (cut, new + 1, cavity, -normal),
    )
    for edges, face, group, way in sides:
        loop = _loop(edges)
        filling = None if loop is None else _filled(points, loop, way)
        if filling is None:
            return None
        points, triangles = filling
        area = Faces(points, triangles, np.zeros(len(triangles), np.int64)).areas.sum()
        if area > WIDENS * opening.area_mm2:
            return None
        parts.append((triangles, np.full(len(triangles), face), np.full(len(triangles), group)))
    triangles, face, groups = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return replace(
        roles,
        surface=replace(surface, points=points, triangles=triangles, face=face),
        groups=groups,
    )


def _beyond(surface: Faces, opening: Opening) -> int:
    """A triangle of the passage at an opening's rim."""
    a, b = opening.rim[0]
    at = (surface.triangles == a).any(axis=1) & (surface.triangles == b).any(axis=1)
    return int(np.flatnonzero(at & (surface.face != opening.face))[0])


def _passage(
    surface: Faces, cavity: np.ndarray, opening: Opening, level: Floats, cap_mm: float
) -> tuple[Ints, Floats] | None:
    """Triangles of a cavity that reach above the plane and hang together with the rim.

    Returns:
        Their rows, and (n,) heights of all points above the plane; None if they do not make up a
        tube that ends at the rim and at the plane.
    """
    lowest = level[opening.rim].min()
    # of planes that are about as deep, the one that misses corners most, as it leaves no slivers
    rim = surface.points[opening.rim].reshape(-1, 3)
    middle = rim.mean(axis=0)
    reach = np.linalg.norm(rim - middle, axis=1).max() + 2 * cap_mm
    inside = np.unique(surface.triangles[cavity])
    inside = inside[np.linalg.norm(surface.points[inside] - middle, axis=1) < reach]
    depths = cap_mm * np.asarray(ABOUT)
    misses = [np.abs(level[inside] - lowest + depth).min() for depth in depths]
    height = level - lowest + depths[int(np.argmax(misses))]
    if max(misses) < MISS * cap_mm:
        return None
    reach = cavity & (height[surface.triangles] > 0).any(axis=1)
    at, ends = surface.pairs
    joined = reach[at].all(axis=1) & (height[ends] > 0).any(axis=1)
    part = parts_of(at[joined], len(surface.triangles))
    rows = np.flatnonzero(reach & (part == part[_beyond(surface, opening)]))
    mine = np.zeros(len(reach), dtype=bool)
    mine[rows] = True
    # the only edges above the plane that it shares with others are the rim's
    border = (mine[at].sum(axis=1) == 1) & (height[ends] > 0).any(axis=1)
    mine_ends = np.unique(np.sort(ends[border], axis=1), axis=0)
    if not np.array_equal(mine_ends, np.unique(np.sort(opening.rim, axis=1), axis=0)):
        return None
    return rows, height


def _cut_off(surface: Faces, rows: Ints, height: Floats) -> tuple[Floats, Faces, Ints]:
    """The part of some triangles that is below the plane.

    Returns:
        All points with those of the cut; the triangles with their faces; and (k, 2) the cut's edges
        as these triangles turn.
    """
    points = [surface.points]
    count = len(surface.points)
    made: dict[tuple[int, int], int] = {}

    def between(a: int, b: int) -> int:
        """The point in the plane on an edge."""
        nonlocal count
        key = (min(a, b), max(a, b))
        if key not in made:
            low, high = key
            share = height[low] / (height[low] - height[high])
            points.append((surface.points[low] * (1 - share) + surface.points[high] * share)[None])
            made[key] = count
            count += 1
        return made[key]

    triangles, face, cut = [], [], []
    for row in rows:
        corners = surface.triangles[row].tolist()
        under = [height[node] < 0 for node in corners]
        if not any(under):
            continue
        outline: list[int] = []
        for i in range(3):
            a, b = corners[i], corners[(i + 1) % 3]
            if under[i]:
                outline.append(a)
            if under[i] != under[(i + 1) % 3]:
                outline.append(between(a, b))
        new = [i for i, node in enumerate(outline) if node >= len(surface.points)]
        first, second = new if (new[0] + 1) % len(outline) == new[1] else new[::-1]
        cut.append((outline[first], outline[second]))
        for i in range(1, len(outline) - 1):
            triangles.append((outline[0], outline[i], outline[i + 1]))
            face.append(surface.face[row])
    every = np.concatenate(points)
    below = Faces(every, np.array(triangles, dtype=np.int64), np.array(face, dtype=np.int64))
    return every, below, np.array(cut, dtype=np.int64)


def _loop(edges: Ints) -> Ints | None:
    """Points of directed edges in their order, (k,); None if they are not one closed line."""
    following = {int(a): int(b) for a, b in edges}
    start = int(edges[0, 0])
    walk, here = [start], following[start]
    while here != start and here in following and len(walk) <= len(edges):
        walk.append(here)
        here = following[here]
    return np.array(walk) if here == start and len(walk) == len(edges) else None


def _filled(points: Floats, loop: Ints, way: Floats) -> tuple[Floats, Ints] | None:
    """Triangles that close a line, and the points with those that they need.

    Args:
        points: (n, 3).
        loop: (k,) as the triangles beside it turn.
        way: (3,) direction that the closing triangles face.
    """
    import pyvista as pv

    turned = loop[::-1]
    middle = points[loop].mean(axis=0)
    fan = np.column_stack([turned, np.roll(turned, -1), np.full(len(turned), len(points))])
    every = np.concatenate([points, middle[None]])
    if (Faces(every, fan, np.zeros(len(fan), np.int64)).vectors @ way > 0).all():
        return every, fan
    polygon = pv.PolyData(points[turned], faces=[len(turned), *range(len(turned))]).triangulate()
    triangles = turned[np.asarray(polygon.regular_faces, dtype=np.int64)]
    if len(triangles) != len(loop) - 2:
        return None
    if (Faces(points, triangles, np.zeros(len(triangles), np.int64)).vectors @ way < 0).any():
        return None
    return points, triangles

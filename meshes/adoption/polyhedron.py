"""A closed surface of triangles as a solid of plane faces in Gmsh's own kernel.

Triangles of a plane face are united, so that only its outline is left; those of a curved face each
become a face of their own. Gmsh can classify and parametrise triangles by itself, but does not come
to an end on some parts.
"""

from __future__ import annotations

from collections import defaultdict

import gmsh
import numpy as np

from dolfingrip.meshes.adoption.surface import Faces, parts_of
from dolfingrip.meshes.solid import Ints, MeshError

STRAIGHT = 1e-6
"""Sine of the angle up to which two edges are one line."""


COPLANAR = 1e-3
"""Sine of the angle up to which two triangles of a curved face are one facet."""


def insert(surface: Faces) -> None:
    """Add the solid to the current, empty model.

    Raises:
        MeshError: if a face's outline is no closed line.
    """
    face = _numbered(surface)
    at, ends = surface.pairs
    border = face[at[:, 0]] != face[at[:, 1]]
    corner = _corners(surface, ends[border])
    tags: dict[int, int] = {}
    lines: dict[tuple[int, int], int] = {}

    def point(node: int) -> int:
        if node not in tags:
            tags[node] = gmsh.model.geo.addPoint(*surface.points[node])
        return tags[node]

    def line(start: int, end: int) -> int:
        if (start, end) in lines:
            return lines[start, end]
        if (end, start) in lines:
            return -lines[end, start]
        lines[start, end] = gmsh.model.geo.addLine(point(start), point(end))
        return lines[start, end]

    directed: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for (one, other), (a, b) in zip(at[border].tolist(), ends[border].tolist(), strict=True):
        directed[int(face[one])].append((a, b))
        directed[int(face[other])].append((b, a))
    made: dict[int, int] = {}
    for number, edges in directed.items():
        loops = [_simple(loop, corner) for loop in _loops(edges)]
        loops.sort(key=lambda loop: -_area(surface, loop))
        curves = [
            gmsh.model.geo.addCurveLoop(
                [line(a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
            )
            for loop in loops
        ]
        made[number] = gmsh.model.geo.addPlaneSurface(curves)
    shell = surface.components()
    volume = np.bincount(shell, surface.volumes)
    shells = []
    for i in np.argsort(-volume):
        shells.append(gmsh.model.geo.addSurfaceLoop([made[f] for f in np.unique(face[shell == i])]))
    gmsh.model.geo.addVolume(shells)
    gmsh.model.geo.synchronize()


def _numbered(surface: Faces) -> Ints:
    """(m,) number of a face for each triangle: connected ones in one plane, single triangles."""
    at, _ = surface.pairs
    plane = surface.plane[surface.face]
    one, other = surface.normals[at[:, 0]], surface.normals[at[:, 1]]
    turn = np.linalg.norm(np.cross(one, other), axis=1)
    flat = plane[at[:, 0]] | (turn < COPLANAR)
    same = (surface.face[at[:, 0]] == surface.face[at[:, 1]]) & flat
    return parts_of(at[same], len(surface.triangles))


def _corners(surface: Faces, edges: Ints) -> np.ndarray:
    """(n,) points at which a line ends."""
    count = np.bincount(edges.ravel(), minlength=len(surface.points))
    corner = count != 2
    others = np.zeros((len(surface.points), 2), dtype=np.int64)
    seen = np.zeros(len(surface.points), dtype=np.int64)
    for a, b in edges:
        for here, there in ((a, b), (b, a)):
            if seen[here] < 2:
                others[here, seen[here]] = there
            seen[here] += 1
    way = surface.points[others] - surface.points[:, None]
    way /= np.maximum(np.linalg.norm(way, axis=2, keepdims=True), 1e-300)
    turn = np.linalg.norm(np.cross(way[:, 0], way[:, 1]), axis=1)
    back = np.einsum("ij,ij->i", way[:, 0], way[:, 1]) > 0
    return np.asarray(corner | (turn > STRAIGHT) | back)


def _loops(edges: list[tuple[int, int]]) -> list[list[int]]:
    """Closed walks along directed edges."""
    following: dict[int, list[int]] = defaultdict(list)
    for a, b in edges:
        following[a].append(b)
    found = []
    while following:
        start = next(iter(following))
        walk, here = [], start
        while True:
            walk.append(here)
            if here not in following:
                raise MeshError("a face's outline is not closed")
            after = following[here].pop()
            if not following[here]:
                del following[here]
            here = after
            if here == start:
                break
        found.append(walk)
    return found


def _simple(loop: list[int], corner: np.ndarray) -> list[int]:
    return [node for node in loop if corner[node]]


def _area(surface: Faces, loop: list[int]) -> float:
    points = surface.points[loop]
    points = points - points[0]
    return float(np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)))

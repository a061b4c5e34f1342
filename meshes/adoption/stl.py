"""A part from a surface of triangles in an STL, OBJ or PLY file.

The closed surface becomes a solid of plane faces in Gmsh's own kernel. Triangles of a plane face
are united, so that only its outline is left; those of a curved face each become a face of their
own. Gmsh can classify and parametrise triangles by itself, but does not come to an end on some
parts.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from operator import itemgetter
from pathlib import Path

import gmsh
import numpy as np

from dolfingrip.meshes.adoption.capping import capped
from dolfingrip.meshes.adoption.facets import OPTIONS, meshed, outward
from dolfingrip.meshes.adoption.formats import MERGED, triangles_of
from dolfingrip.meshes.adoption.roles import Asked, Box, Roles, assign, said_of
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes, measured
from dolfingrip.meshes.adoption.sound import check_crossings, check_watertight
from dolfingrip.meshes.adoption.surface import (
    FacePolicy,
    Faces,
    consistent,
    pairs,
    segmented,
)
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.groups import CLAMP
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import Floats, Ints, MeshError, SolidMesh, parts_of


def adopt_stl(
    path: Path, hints: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    """The mesh of the solid that a file's triangles enclose.

    Raises:
        MeshError: one line, without the file's name.
    """
    surface = _read(path, hints, scale)
    masks = {}
    if hints.held:
        surface, masks[CLAMP] = _released(surface, hints.held)
    roles = assign(surface, hints, masks)
    sizes = measured(roles, wanted)
    return meshed_triangles(capped(roles, sizes.cap_mm), sizes, wanted)


def meshed_triangles(
    roles: Roles, sizes: WallSizes, wanted: MeshRequest
) -> tuple[SolidMesh, Roles, WallSizes]:
    """The mesh within a part's triangles, of its half if it has one.

    Raises:
        MeshError: one line, without the file's name.
    """
    poor = None
    if roles.half:
        try:
            poor = _meshed(_half(roles.surface), roles, sizes, wanted)
            if check(poor).scaled_jacobian_min >= wanted.policy.poor:
                return poor, roles, sizes
        except MeshError:
            poor = None
    whole_roles = roles.as_whole("its half cannot be meshed well; the whole is computed")
    if not roles.half:
        whole_roles = roles
    try:
        return _meshed(roles.surface, whole_roles, sizes, wanted), whole_roles, sizes
    except MeshError:
        if poor is None:
            raise
        return poor, roles, sizes


def _meshed(surface: Faces, roles: Roles, sizes: WallSizes, wanted: MeshRequest) -> SolidMesh:
    """The mesh within a closed surface.

    Raises:
        MeshError: one line, if there is none.
    """
    with session("not meshed", OPTIONS):
        insert(surface)
        mesh = meshed(roles, sizes, wanted, curved=False)
    check(mesh)
    return mesh


def _released(surface: Faces, held: Sequence[Box | str]) -> tuple[Faces, np.ndarray]:
    """The surface without the end that a box holds, and (m,) its triangles in the cut.

    Raises:
        MeshError: one line, if a box's sides cut the part in several planes.
    """
    cut = np.zeros(0, dtype=bool)
    for box in held:
        planes = []
        if not isinstance(box, str):
            corners = np.array(box).reshape(2, 3)
            low, high = surface.points.min(axis=0), surface.points.max(axis=0)
            for axis in range(3):
                for value, sign in ((corners.min(axis=0), -1.0), (corners.max(axis=0), 1.0)):
                    if low[axis] < value[axis] < high[axis]:
                        planes.append((value, sign * np.eye(3)[axis]))
        if len(planes) != 1:
            raise MeshError(
                f"--clamp-region {said_of(box)}: allowed of triangles: a box around one end, of "
                "which one side cuts the part; or a STEP file"
            )
        surface = _clipped(surface, *planes[0])
        cut = np.abs((surface.middles - planes[0][0]) @ planes[0][1]) < surface.near_mm
    return surface, cut


def _read(path: Path, hints: Asked, scale: float) -> Faces:
    """The surface, in faces.

    Raises:
        MeshError: one line, if it does not enclose a solid.
    """
    points, triangles = triangles_of(path, scale)
    if hints.repair:
        points, triangles = _repaired(points, triangles)
    for file in hints.cavity_files:
        walls = triangles_of(file, scale)
        if _fills(walls[0], points, triangles):
            triangles = np.concatenate([triangles, walls[1] + len(points)])
            points = np.concatenate([points, walls[0]])
    try:
        check_watertight(points, triangles)
    except MeshError as error:
        raise MeshError(str(error) if hints.repair else f"{error}, or --repair") from None
    check_crossings(points, triangles)
    surface = outward(Faces(points, triangles, np.zeros(len(triangles), np.int64)))
    return replace(surface, face=segmented(points, surface.triangles, surface.policy))


def _repaired(points: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """The surface with its holes closed and its crossings resolved, by MeshFix.

    Raises:
        ModuleNotFoundError: if the library is not installed.
    """
    from pymeshfix import MeshFix

    parts = parts_of(pairs(triangles)[0], len(triangles))
    shells = []
    for number in np.unique(parts):  # MeshFix unites shells or drops them
        used, local = np.unique(triangles[parts == number], return_inverse=True)
        fix = MeshFix(points[used], local.reshape(-1, 3).astype(np.int32))
        fix.repair()
        shells.append((np.asarray(fix.points, dtype=float), np.asarray(fix.faces, dtype=np.int64)))
    starts = np.cumsum([0, *(len(mine) for mine, _ in shells)])
    return (
        np.concatenate([mine for mine, _ in shells]),
        np.concatenate([rows + start for (_, rows), start in zip(shells, starts, strict=False)]),
    )


def _fills(walls: Floats, points: Floats, triangles: Ints) -> bool:
    """Return whether a cavity's walls lie within the solid, so that it is to be hollowed out.

    Raises:
        MeshError: one line, if they lie neither inside nor on the solid's surface.
    """
    body = consistent(points, triangles)
    away = ClosedSurface(points, body).distances_mm(walls)
    near = FacePolicy().near * float(np.ptp(points, axis=0).max())
    if away.max() < -near:
        return True
    if np.abs(away).max() > near:
        raise MeshError(
            "--cavity: its triangles leave the body; allowed: inside it, or on its own walls; "
            "or STEP files of both"
        )
    return False


def _half(surface: Faces) -> Faces:
    """The half y ≥ 0 of a surface, closed in the plane y = 0."""
    return _clipped(surface, np.zeros(3), np.array([0.0, 1.0, 0.0]))


def _clipped(surface: Faces, at: Floats, way: Floats) -> Faces:
    """The part of a surface on one side of a plane, closed there.

    Args:
        surface: closed.
        at: (3,) point of the plane.
        way: (3,) unit normal, towards the part that stays.

    Raises:
        MeshError: one line, if the cut cannot be closed.
    """
    points = surface.points.copy()
    near = 1e-6 * surface.extent
    level = (points - at) @ way
    points -= np.where(np.abs(level) < near, level, 0.0)[:, None] * way
    mesh = ClosedSurface(points, surface.triangles).polydata()
    cut = (
        mesh.clip_closed_surface(normal=way, origin=at, tolerance=MERGED)
        .triangulate()
        .clean(tolerance=MERGED)
    )
    triangles = np.asarray(cut.regular_faces, dtype=np.int64)
    points = np.asarray(cut.points, dtype=float)
    try:
        check_watertight(points, triangles)
    except MeshError:
        raise MeshError(
            "it cannot be cut in a plane; allowed: --whole, or without --clamp-region"
        ) from None
    face = segmented(points, triangles, surface.policy)
    return replace(surface, points=points, triangles=triangles, face=face)


STRAIGHT = 1e-6
"""Sine of the angle up to which two edges are one line."""


COPLANAR = 1e-3
"""Sine of the angle up to which two triangles of a curved face are one facet."""


ROUNDED = 1e-5
"""Distance by the extent up to which a point is off a plane by rounding: single precision, as of a
binary STL, rounds by 6e-8 of the distance from the origin."""


def insert(surface: Faces) -> None:
    """Add the solid to the current, empty model.

    Raises:
        MeshError: if a face's outline is no closed line.
    """
    face = _numbered(surface)
    surface = replace(surface, points=_flattened(surface, face))
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
        loops = [[node for node in loop if corner[node]] for loop in _loops(edges)]
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
    """Number of a face for each triangle, (m,): connected ones in one plane, single triangles."""
    at, _ = surface.pairs
    plane = surface.plane[surface.face]
    one, other = surface.normals[at[:, 0]], surface.normals[at[:, 1]]
    turn = np.linalg.norm(np.cross(one, other), axis=1)
    flat = plane[at[:, 0]] | (turn < COPLANAR)
    same = (surface.face[at[:, 0]] == surface.face[at[:, 1]]) & flat
    return parts_of(at[same], len(surface.triangles))


def _flattened(surface: Faces, face: Ints) -> Floats:
    """Points, each in all planes of its faces that it is off by rounding, (n, 3).

    A part that is turned has no coordinate in common along a plane, so that rounding bends plane
    faces and their straight edges, which would end at each point.

    Args:
        surface: of which a face is plane.
        face: (m,) number of a plane face for each triangle.
    """
    pairs = np.column_stack([surface.triangles.ravel(), np.repeat(face, 3)])
    point, of = np.unique(pairs, axis=0).T
    count = np.bincount(of)
    normal = replace(surface, face=face).face_vectors
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    level = np.einsum("ij,ij->i", surface.points[point], normal[of])
    level = np.bincount(of, level) / count
    more = count[of] > 3  # a triangle is plane
    memberships = zip(point[more].tolist(), of[more].tolist(), strict=True)
    alike: dict[tuple[int, ...], list[int]] = defaultdict(list)
    for one, its_planes in groupby(memberships, key=itemgetter(0)):
        alike[tuple(plane for _, plane in its_planes)].append(one)
    points = surface.points.copy()
    for planes, every in alike.items():
        normals = normal[[*planes]]
        off = level[[*planes]] - points[every] @ normals.T
        # planes within some 6° of one another do not tell where they meet
        step = off @ np.linalg.pinv(normals, rcond=0.05).T
        rounded = np.linalg.norm(step, axis=1) < ROUNDED * surface.extent
        points[every] += np.where(rounded[:, None], step, 0.0)
    return points


def _corners(surface: Faces, edges: Ints) -> np.ndarray:
    """Points at which a line ends, (n,)."""
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
    walks = []
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
        walks.append(walk)
    return walks


def _area(surface: Faces, loop: list[int]) -> float:
    points = surface.points[loop]
    points = points - points[0]
    return float(np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)))

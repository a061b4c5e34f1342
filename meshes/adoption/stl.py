"""A part from a surface of triangles in an STL, OBJ or PLY file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from dolfingrip.meshes.adoption.capping import capped
from dolfingrip.meshes.adoption.facets import OPTIONS, meshed, outward
from dolfingrip.meshes.adoption.formats import MERGED, triangles_of
from dolfingrip.meshes.adoption.policy import FacePolicy
from dolfingrip.meshes.adoption.polyhedron import insert
from dolfingrip.meshes.adoption.roles import Asked, Box, Roles, assign, said_of
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes, measured
from dolfingrip.meshes.adoption.sound import check_crossings, check_watertight
from dolfingrip.meshes.adoption.surface import Faces, consistent, pairs, parts_of, segmented
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.groups import CLAMP
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import Floats, Ints, MeshError, SolidMesh


def adopt_stl(
    path: Path, asked: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    """The mesh of the solid that a file's triangles enclose.

    Raises:
        MeshError: one line, without the file's name.
    """
    surface = _read(path, asked, scale)
    known = {}
    if asked.held:
        surface, known[CLAMP] = _released(surface, asked.held)
    roles = assign(surface, asked, known)
    found = measured(roles, wanted)
    return meshed_triangles(capped(roles, found.cap_mm), found, wanted)


def meshed_triangles(
    roles: Roles, found: WallSizes, wanted: MeshRequest
) -> tuple[SolidMesh, Roles, WallSizes]:
    """The mesh within a part's triangles, of its half if it has one.

    Raises:
        MeshError: one line, without the file's name.
    """
    poor = None
    if roles.half:
        try:
            poor = _meshed(_half(roles.surface), roles, found, wanted)
            if check(poor).scaled_jacobian_min >= wanted.policy.poor:
                return poor, roles, found
        except MeshError:
            poor = None
    whole = roles.as_whole("its half cannot be meshed well; the whole is computed")
    if not roles.half:
        whole = roles
    try:
        return _meshed(roles.surface, whole, found, wanted), whole, found
    except MeshError:
        if poor is None:
            raise
        return poor, roles, found


def _meshed(surface: Faces, roles: Roles, found: WallSizes, wanted: MeshRequest) -> SolidMesh:
    """The mesh within a closed surface.

    Raises:
        MeshError: one line, if there is none.
    """
    with session("not meshed", OPTIONS):
        insert(surface)
        mesh = meshed(roles, found, wanted, curved=False)
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


def _read(path: Path, asked: Asked, scale: float) -> Faces:
    """The surface, in faces.

    Raises:
        MeshError: one line, if it does not enclose a solid.
    """
    points, triangles = triangles_of(path, scale)
    if asked.repair:
        points, triangles = _repaired(points, triangles)
    for file in asked.cavity_files:
        walls = triangles_of(file, scale)
        if _fills(walls[0], points, triangles):
            triangles = np.concatenate([triangles, walls[1] + len(points)])
            points = np.concatenate([points, walls[0]])
    try:
        check_watertight(points, triangles)
    except MeshError as error:
        raise MeshError(str(error) if asked.repair else f"{error}, or --repair") from None
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
    found = []
    for number in np.unique(parts):  # MeshFix unites shells or drops them
        used, local = np.unique(triangles[parts == number], return_inverse=True)
        fix = MeshFix(points[used], local.reshape(-1, 3).astype(np.int32))
        fix.repair()
        found.append((np.asarray(fix.points, dtype=float), np.asarray(fix.faces, dtype=np.int64)))
    starts = np.cumsum([0, *(len(mine) for mine, _ in found)])
    return (
        np.concatenate([mine for mine, _ in found]),
        np.concatenate([rows + start for (_, rows), start in zip(found, starts, strict=False)]),
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
    import pyvista as pv
    from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPlaneCollection
    from vtkmodules.vtkFiltersGeneral import vtkClipClosedSurface

    points = surface.points.copy()
    near = 1e-6 * surface.extent
    level = (points - at) @ way
    points -= np.where(np.abs(level) < near, level, 0.0)[:, None] * way
    mesh = pv.PolyData(points, faces=np.insert(surface.triangles, 0, 3, axis=1).ravel())
    plane, planes = vtkPlane(), vtkPlaneCollection()
    plane.SetNormal(*way)
    plane.SetOrigin(*at)
    planes.AddItem(plane)
    clip = vtkClipClosedSurface()
    clip.SetInputData(mesh)
    clip.SetClippingPlanes(planes)
    clip.SetTolerance(MERGED)
    clip.Update()
    cut = pv.wrap(clip.GetOutput()).triangulate().clean(tolerance=MERGED)
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

"""A part from a surface of triangles in an STL, OBJ or PLY file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from dolfingrip.meshes.adoption.capping import capped
from dolfingrip.meshes.adoption.facets import OPTIONS, meshed, outward
from dolfingrip.meshes.adoption.polyhedron import insert
from dolfingrip.meshes.adoption.roles import Asked, Roles, assign
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes, measured
from dolfingrip.meshes.adoption.sound import check_crossings, check_watertight
from dolfingrip.meshes.adoption.surface import Faces, segmented
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

READABLE = (".stl", ".obj", ".ply")

MERGED = 1e-6
"""Distance, relative to the extent, up to which corners of triangles are one point."""


def adopt_stl(
    path: Path, asked: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    """The mesh of the solid that a file's triangles enclose.

    Raises:
        MeshError: one line, without the file's name.
    """
    roles = assign(_read(path, scale), asked)
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


def _read(path: Path, scale: float) -> Faces:
    """The surface, in faces.

    Raises:
        MeshError: one line, if it does not enclose a solid.
    """
    import pyvista as pv

    try:
        raw = pv.read(path)
    except Exception as error:  # any error of the parser on a broken file
        raise MeshError(f"not readable: {error}; allowed: triangles") from None
    if not isinstance(raw, pv.PolyData) or not raw.n_cells:
        raise MeshError("no triangles; allowed: a closed surface of triangles")
    merged = raw.triangulate().clean(
        tolerance=MERGED, lines_to_points=False, polys_to_lines=False, strips_to_polys=False
    )
    points = np.asarray(merged.points, dtype=float) * scale
    triangles = np.asarray(merged.regular_faces, dtype=np.int64)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    check_watertight(points, triangles)
    check_crossings(points, triangles)
    surface = outward(Faces(points, triangles, np.zeros(len(triangles), np.int64)))
    return replace(surface, face=segmented(points, surface.triangles, surface.policy))


def _half(surface: Faces) -> Faces:
    """The half y ≥ 0 of a surface, closed in the plane y = 0."""
    import pyvista as pv
    from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPlaneCollection
    from vtkmodules.vtkFiltersGeneral import vtkClipClosedSurface

    points = surface.points.copy()
    near = 1e-6 * surface.extent
    points[np.abs(points[:, 1]) < near, 1] = 0.0
    mesh = pv.PolyData(points, faces=np.insert(surface.triangles, 0, 3, axis=1).ravel())
    plane, planes = vtkPlane(), vtkPlaneCollection()
    plane.SetNormal(0, 1, 0)
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
        raise MeshError("its half cannot be cut; allowed: --whole") from None
    face = segmented(points, triangles, surface.policy)
    return replace(surface, points=points, triangles=triangles, face=face)

"""Groups of the faces of Gmsh's current model, by the part's triangles that they lie on."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import gmsh
import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.adoption.roles import Roles
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes
from dolfingrip.meshes.adoption.sound import SizePolicy
from dolfingrip.meshes.adoption.surface import Faces, consistent
from dolfingrip.meshes.closed_surface import nearest
from dolfingrip.meshes.gmsh_model import current_mesh, numbered_nodes
from dolfingrip.meshes.solid import Floats, SolidMesh

OPTIONS = {
    "Mesh.MeshSizeExtendFromBoundary": 1.0,
    "Mesh.MeshSizeFromPoints": 0.0,
    "Mesh.Algorithm": 6.0,
    "Mesh.Algorithm3D": 1.0,
    "Mesh.Optimize": 1.0,
    "Mesh.OptimizeThreshold": 0.5,
    "Mesh.ElementOrder": 1.0,
    "Mesh.SecondOrderLinear": 0.0,
}
"""Gmsh's numbers for parts."""

DELAUNAY, HXT = 1.0, 10.0
"""Gmsh's ways to fill a surface: the first is faster, but leaves slivers at times, and does not end
between facets so close to one another that elements are larger than the walls ask for."""


def triangulated(surfaces: list[int]) -> Faces:
    """The triangles of some faces of the current, meshed model.

    Args:
        surfaces: tags of the faces; the place in this list numbers the face of a triangle.
    """
    every, index = numbered_nodes()
    corners, face = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)]
    for number, surface in enumerate(surfaces):
        nodes = gmsh.model.mesh.getElementsByType(2, surface)[1].astype(np.int64)
        corners.append(index[nodes].reshape(-1, 3))
        face.append(np.full(len(corners[-1]), number))
    triangles, of = np.concatenate(corners), np.concatenate(face)
    used, local = np.unique(triangles, return_inverse=True)
    return Faces(every[used], local.reshape(-1, 3).astype(np.int64), of)


def outward(surface: Faces) -> Faces:
    """The surface with its triangles seen from outside.

    Args:
        surface: closed; its triangles may be turned either way.
    """
    return replace(surface, triangles=consistent(surface.points, surface.triangles))


def meshed(roles: Roles, sizes: WallSizes, wanted: MeshRequest, *, curved: bool) -> SolidMesh:
    """Mesh the current model, which is in the finger's frame, with its groups.

    Args:
        roles: what the part's faces are taken for.
        sizes: size of the elements.
        wanted: order of the elements.
        curved: whether faces can be curved.
    """
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", wanted.policy.curved if curved else 0.0)
    close = sizes.size_mm > 1.01 * wanted.policy.by_wall * sizes.wall.mm
    gmsh.option.setNumber("Mesh.Algorithm3D", HXT if close and not curved else DELAUNAY)
    _generate(sizes.size_mm, wanted.policy)
    order = wanted.order or (2 if curved and not roles.surface.plane.all() else 1)
    _add_groups(roles)
    if order == 2:
        gmsh.model.mesh.setOrder(2)
        if curved:
            gmsh.model.mesh.optimize("HighOrder")
    return in_frame(current_mesh(), roles)


def _generate(size_mm: float, policy: SizePolicy) -> None:
    """Mesh the current model; where there are slivers, by HXT, and then with smaller elements.

    Where these leave the worst sliver as it is, the facets make it.
    """
    before = np.nan
    for smaller in (1.0, *policy.tried):
        gmsh.model.mesh.clear()
        gmsh.option.setNumber("Mesh.MeshSizeMax", smaller * size_mm)
        gmsh.option.setNumber("Mesh.MeshSizeMin", smaller * size_mm / 3)
        gmsh.model.mesh.generate(3)
        tags = gmsh.model.mesh.getElementsByType(4)[0]
        worst = gmsh.model.mesh.getElementQualities(tags, "gamma").min(initial=1.0)
        if worst >= policy.sliver or np.isclose(worst, before, rtol=1e-3, atol=0.0):
            return
        before = worst
        gmsh.option.setNumber("Mesh.Algorithm3D", HXT)


def in_frame(mesh: SolidMesh, roles: Roles) -> SolidMesh:
    """The mesh with the clamp and the symmetry plane exactly in their planes, and with its tip."""
    points = mesh.points.copy()
    near = 1e-5 * roles.surface.extent
    for axis, name in ((2, groups.CLAMP), (1, groups.SYMMETRY)):
        if name in mesh.facets:
            nodes = np.unique(mesh.facets[name])
            flat = nodes[np.abs(points[nodes, axis]) < near]
            points[flat, axis] = 0.0
    facets = dict(mesh.facets)
    if roles.tip_from_mm is not None:
        skin = facets[groups.SKIN]
        late = points[skin[:, :3], 2].mean(axis=1) > roles.tip_from_mm
        facets[groups.SKIN], facets[groups.TIP] = skin[~late], skin[late]
    return replace(mesh, points=points, facets=facets)


def _add_groups(roles: Roles) -> None:
    """Make physical groups of the volumes and faces of the current, meshed model."""
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    gmsh.model.addPhysicalGroup(3, volumes, groups.SOLID_TAG, groups.SOLID)
    outer = [tag for _, tag in gmsh.model.getBoundary([(3, v) for v in volumes], oriented=False)]
    names: dict[str, list[int]] = defaultdict(list)
    near = roles.surface.near_mm
    # all faces at once: a part of triangles has thousands
    part = triangulated(outer)
    rows, away = nearest(roles.surface.points, roles.surface.triangles, part.middles)
    order = np.argsort(part.face, kind="stable")
    starts = np.searchsorted(part.face[order], np.arange(1, len(outer)))
    for tag, mine in zip(outer, np.split(order, starts), strict=True):
        on_plane = np.abs(part.points[part.triangles[mine], 1]).max(initial=0.0) < 1e-2 * near
        if roles.half and on_plane:
            names[groups.SYMMETRY].append(tag)
            continue
        if away[mine].mean() > 5 * near:  # of a cap: its outer side belongs to the face it closes
            names[_of_cap(part.middles[mine].mean(axis=0), roles)].append(tag)
            continue
        of = roles.groups[rows[mine]]
        votes = {name: float(part.areas[mine][of == name].sum()) for name in np.unique(of)}
        name = max(votes, key=lambda group: votes[group])
        if roles.tip_from_mm is not None and name == groups.TIP:
            name = groups.SKIN
        names[name].append(tag)
    for name in groups.surfaces(names):
        gmsh.model.addPhysicalGroup(2, names[name], groups.surface_tag(name), name)


def _of_cap(middle: Floats, roles: Roles) -> str:
    """Group of a cap's side: that of the face with the opening outside, the cavity's inside."""
    near = roles.surface.near_mm
    sides: list[tuple[float, str]] = []
    for name, hollow in roles.named.items():
        for opening in hollow.openings:
            centre = roles.rotation @ (opening.centre_mm - roles.origin_mm)
            level = (middle - centre) @ (roles.rotation @ opening.normal)
            group = roles.groups[roles.surface.face == opening.face][0]
            sides.append((float(np.linalg.norm(middle - centre)), group if level > -near else name))
    return min(sides)[1]

"""Adopt a user's own part: its mesh in the finger's frame, and what of it was taken for what."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay

from dolfingrip.meshes import files, groups
from dolfingrip.meshes.adoption.facets import in_frame
from dolfingrip.meshes.adoption.formats import (
    CAD,
    MESHES,
    SURFACES,
    require_bearable,
    triangles_of,
)
from dolfingrip.meshes.adoption.roles import Asked, Box, Roles, assign, said_of
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes, measured
from dolfingrip.meshes.adoption.sound import place
from dolfingrip.meshes.adoption.surface import Faces, consistent, segmented
from dolfingrip.meshes.closed_surface import nearest
from dolfingrip.meshes.measures import centroid, edge_lengths
from dolfingrip.meshes.quality import Quality, check, judge
from dolfingrip.meshes.solid import (
    Floats,
    Ints,
    MeshError,
    SolidMesh,
    assemble,
    boundary,
    faces,
    labels,
    match,
)
from dolfingrip.sections.units import doubted

ANOTHER_SIZE = "try another --size-mm"
OF_TRIANGLES = f"{ANOTHER_SIZE}, or the STEP file in place of triangles"
MESHED_ANEW = "mesh it anew where it comes from, or adopt its STEP or STL file"
ADVICE = {**dict.fromkeys(SURFACES, OF_TRIANGLES), **dict.fromkeys(MESHES, MESHED_ANEW)}
"""What to do about a mesh that is not good, by the ending of the part's file."""


@dataclass(frozen=True, slots=True)
class AdoptedPart:
    """An adopted part.

    Attributes:
        mesh: in the finger's frame, with groups.
        quality: figures of the checked mesh.
        warnings: what is not good about the mesh, in sentences.
        roles: what the part's faces were taken for.
        measured: walls, gaps and sizes.
        bends_to_back: whether a first step of pressure bends it towards its back.
    """

    mesh: SolidMesh
    quality: Quality
    warnings: tuple[str, ...]
    roles: Roles
    measured: WallSizes
    bends_to_back: bool = False

    @property
    def size_mm(self) -> np.ndarray:
        """Depth along x, width along y, length along z, (3,)."""
        surface = self.roles.surface
        return np.asarray(np.ptp(surface.points[surface.triangles].reshape(-1, 3), axis=0))

    @property
    def centroid_x_mm(self) -> float:
        """The centre of gravity's distance from the back."""
        return float(centroid(self.mesh)[0])


def adopt(path: Path, hints: Asked, wanted: MeshRequest, scale: float = 1.0) -> AdoptedPart:
    """Adopt a part.

    Args:
        path: CAD file, triangles or mesh.
        hints: corrections of what is taken for what.
        wanted: size and order of elements.
        scale: mm for each unit of length of the file.

    Raises:
        MeshError: one line that says what is wrong with the part, and where.
    """
    suffix = path.suffix.lower()
    if not path.is_file():
        raise MeshError(f"{path}: no such file")
    if suffix in CAD:
        from dolfingrip.meshes.adoption.step import adopt_step as make
    elif suffix in SURFACES:
        from dolfingrip.meshes.adoption.stl import adopt_stl as make
    elif suffix in MESHES:
        from dolfingrip.meshes.adoption.adopt import adopt_mesh as make
    else:
        raise MeshError(f"{path}: unknown format; allowed: {', '.join((*CAD, *SURFACES, *MESHES))}")
    try:
        for file in hints.cavity_files:
            if not file.is_file():
                raise MeshError(f"--cavity {file}: no such file")
        if suffix in CAD:
            require_bearable(path)
        walls = [triangles_of(file, scale)[0] for file in hints.cavity_files]
        hints = replace(hints, cavities=[*hints.cavities, *walls])
        mesh, roles, measured = make(path, hints, wanted, scale)
        quality = check(mesh)
        warnings = judge(mesh, quality, ADVICE.get(suffix, ANOTHER_SIZE))
        part = AdoptedPart(mesh, quality, warnings, roles, measured)
        return replace(part, warnings=(*doubted(float(part.size_mm[2]), scale), *warnings))
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def adopt_mesh(
    path: Path, hints: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    """A file's mesh in the finger's frame, with groups where it has none.

    Raises:
        MeshError: one line.
    """
    if wanted.size_mm is not None or wanted.order is not None:
        raise MeshError("elements stay as they are; allowed: without --size-mm and --order")
    mesh = files.read(path, needed=())
    mesh = replace(mesh, points=mesh.points * scale)
    held: np.ndarray = np.zeros(len(mesh.points), dtype=bool)
    for region in hints.held:
        mesh, held = _released(mesh, region, held)
    outer = faces(mesh.cells)[boundary(mesh.cells)]
    corners = mesh.shape.facet_corners
    split = [[0, 1, 2]] if corners == 3 else [[0, 1, 2], [0, 2, 3]]
    triangles = outer[:, split].reshape(-1, 3)
    of = np.repeat(np.arange(len(outer)), len(split))
    used, local = np.unique(triangles, return_inverse=True)
    surface = Faces(mesh.points[used], local.reshape(-1, 3).astype(np.int64), of)
    surface = replace(surface, face=segmented(surface.points, surface.triangles, surface.policy))
    masks = _known(mesh, outer, of)
    if hints.held:
        masks[groups.CLAMP] = np.asarray(np.isin(outer, np.flatnonzero(held)).all(axis=1))[of]
    walls = [triangles_of(file, scale) for file in hints.cavity_files]
    for name, wall in zip(groups.cavity_names(len(walls)), walls, strict=True):
        masks[name] = _on_walls(surface, *wall) & ~masks.get(groups.CLAMP, np.zeros(len(of), bool))
    roles = assign(surface, replace(hints, whole=True), masks)
    if roles.caps:
        raise MeshError(
            f"an opening at {place(roles.caps[0].centre_mm)} is away from the clamp; allowed: "
            "openings at the clamp (--clamp, --clamp-region), or a STEP file, whose openings are "
            "capped"
        )
    first = np.searchsorted(of, np.arange(len(outer)))
    names = roles.groups[first]
    facets = {name: outer[names == name] for name in np.unique(names)}
    points = (mesh.points - roles.origin_mm) @ roles.rotation.T
    roles.said["symmetry"] = "a mesh is taken as it is, whole"
    size = float(np.median(edge_lengths(mesh)))
    sizes = replace(measured(roles, MeshRequest()), size_mm=size)
    return in_frame(replace(mesh, points=points, facets=facets), roles), roles, sizes


def _released(mesh: SolidMesh, region: Box | str, held: np.ndarray) -> tuple[SolidMesh, np.ndarray]:
    """The mesh without the elements that a region holds, and (n,) whether each node left is held.

    Args:
        mesh: without the elements of earlier regions.
        region: a box, whose nodes are held; a region of the mesh; or a group of facets, as those
            around a collar, which hold the nodes that they surround.
        held: (n,) nodes that earlier regions hold.

    Raises:
        MeshError: one line, if it holds nothing or all.
    """
    if region in mesh.facets:
        inside = _surrounded(mesh.points, mesh.points[np.unique(mesh.facets[region])])
        gone: np.ndarray = np.asarray(inside[mesh.cells].all(axis=1))
    elif isinstance(region, str):
        if region not in mesh.regions:
            allowed = ", ".join([*mesh.regions, *mesh.facets]) or "X,Y,Z,X,Y,Z"
            raise MeshError(f"--clamp-region {region}: no such region; allowed: {allowed}")
        gone = np.zeros(len(mesh.cells), dtype=bool)
        gone[mesh.regions[region]] = True
        inside = np.isin(np.arange(len(mesh.points)), mesh.cells[gone])
    else:
        corners = np.array(region).reshape(2, 3)
        near = 1e-6 * float(np.ptp(mesh.points, axis=0).max())
        low, high = corners.min(axis=0) - near, corners.max(axis=0) + near
        inside = ((mesh.points >= low) & (mesh.points <= high)).all(axis=1)
        gone = inside[mesh.cells].all(axis=1)
    if gone.all() or not inside.any():
        raise MeshError(
            f"--clamp-region {said_of(region)}: holds {'all' if gone.all() else 'nothing'} of the "
            "mesh; allowed: a box, by two corners, around the nodes that are held"
        )
    new = np.cumsum(~gone) - 1
    regions = {name: new[rows[~gone[rows]]] for name, rows in mesh.regions.items()}
    cells = mesh.cells[~gone]
    facets = {name: rows[match(rows, cells) >= 0] for name, rows in mesh.facets.items()}
    kept = np.unique(cells)
    return assemble(mesh.points, cells, facets, regions), (held | inside)[kept]


def _surrounded(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Mask (n,) of points in the convex hull of others; of none where these lie in a plane."""
    middle, size = others.mean(axis=0), float(np.ptp(others, axis=0).max())
    if np.linalg.matrix_rank(others - middle, tol=1e-6 * size) < 3:
        return np.zeros(len(points), dtype=bool)
    hull = Delaunay(middle + (1 + 1e-6) * (others - middle))
    return np.asarray(hull.find_simplex(points) >= 0)


def _on_walls(surface: Faces, points: Floats, triangles: Ints) -> np.ndarray:
    """Mask, (m,): whether a triangle lies on the walls of a cavity, which has its own triangles."""
    walls = consistent(points, triangles)
    rows, away = nearest(points, walls, surface.middles)
    a, b, c = (points[walls[rows, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    # the outer side of a thin wall is as near, but faces the other way
    facing = np.einsum("ij,ij->i", normal, surface.normals) < -surface.policy.rim
    return facing & (away < surface.policy.rim * np.sqrt(surface.areas))


def _known(mesh: SolidMesh, outer: np.ndarray, of: np.ndarray) -> dict[str, np.ndarray]:
    """Triangles of each group that the file has and that needs no guess, (m,)."""
    masks = {}
    for name, facets in mesh.facets.items():
        if name not in (groups.SKIN, groups.SYMMETRY) and len(facets):
            label = labels(np.concatenate([outer, facets]))
            masks[name] = np.isin(label[: len(outer)], label[len(outer) :])[of]
    return masks

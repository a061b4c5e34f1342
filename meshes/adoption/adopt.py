"""Adopt a user's own part: its mesh in the finger's frame, and what of it was taken for what."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.meshes import files, groups
from dolfingrip.meshes.adoption.facets import in_frame
from dolfingrip.meshes.adoption.roles import Asked, Roles, assign
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes, measured
from dolfingrip.meshes.adoption.sound import place
from dolfingrip.meshes.adoption.surface import Faces, segmented
from dolfingrip.meshes.measures import centroid, edge_lengths
from dolfingrip.meshes.quality import Quality, check
from dolfingrip.meshes.solid import MeshError, SolidMesh, boundary, faces, labels

CAD: Final = (".step", ".stp", ".brep", ".iges", ".igs")
SURFACES: Final = (".stl", ".obj", ".ply")
MESHES: Final = (".msh", ".inp", ".vtk", ".vtu")


@dataclass(frozen=True, slots=True)
class AdoptedPart:
    """An adopted part.

    Attributes:
        mesh: in the finger's frame, with groups.
        quality: figures of the checked mesh.
        roles: what the part's faces were taken for.
        measured: walls, gaps and sizes.
    """

    mesh: SolidMesh
    quality: Quality
    roles: Roles
    measured: WallSizes

    @property
    def size_mm(self) -> np.ndarray:
        """(3,) depth along x, width along y, length along z."""
        surface = self.roles.surface
        return np.asarray(np.ptp(surface.points[surface.triangles].reshape(-1, 3), axis=0))

    @property
    def centroid_x_mm(self) -> float:
        """The centre of gravity's distance from the back."""
        return float(centroid(self.mesh)[0])


def adopt(path: Path, asked: Asked, wanted: MeshRequest, scale: float = 1.0) -> AdoptedPart:
    """Adopt a part.

    Args:
        path: CAD file, triangles or mesh.
        asked: corrections of what is taken for what.
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
        mesh, roles, measured = make(path, asked, wanted, scale)
        return AdoptedPart(mesh, check(mesh), roles, measured)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def adopt_mesh(
    path: Path, asked: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    """A file's mesh in the finger's frame, with groups where it has none.

    Raises:
        MeshError: one line.
    """
    if wanted.size_mm is not None or wanted.order is not None:
        raise MeshError("elements stay as they are; allowed: without --size-mm and --order")
    mesh = files.read(path, needed=())
    mesh = replace(mesh, points=mesh.points * scale)
    outer = faces(mesh.cells)[boundary(mesh.cells)]
    corners = mesh.shape.facet_corners
    split = [[0, 1, 2]] if corners == 3 else [[0, 1, 2], [0, 2, 3]]
    triangles = outer[:, split].reshape(-1, 3)
    of = np.repeat(np.arange(len(outer)), len(split))
    used, local = np.unique(triangles, return_inverse=True)
    surface = Faces(mesh.points[used], local.reshape(-1, 3).astype(np.int64), of)
    surface = replace(surface, face=segmented(surface.points, surface.triangles, surface.policy))
    roles = assign(surface, replace(asked, whole=True), _known(mesh, outer, of))
    if roles.caps:
        raise MeshError(
            f"an opening at {place(roles.caps[0].centre_mm)} is away from the clamp; allowed: "
            "openings in the clamp's plane (--clamp), or a STEP file, whose openings are capped"
        )
    first = np.searchsorted(of, np.arange(len(outer)))
    names = roles.groups[first]
    facets = {name: outer[names == name] for name in np.unique(names)}
    points = (mesh.points - roles.origin_mm) @ roles.rotation.T
    roles.said["symmetry"] = "a mesh is taken as it is, whole"
    size = float(np.median(edge_lengths(mesh)))
    found = replace(measured(roles, MeshRequest()), size_mm=size)
    return in_frame(replace(mesh, points=points, facets=facets), roles), roles, found


def _known(mesh: SolidMesh, outer: np.ndarray, of: np.ndarray) -> dict[str, np.ndarray]:
    """(m,) triangles of each group that the file has and that needs no guess."""
    found = {}
    for name, facets in mesh.facets.items():
        if name not in (groups.SKIN, groups.SYMMETRY) and len(facets):
            label = labels(np.concatenate([outer, facets]))
            found[name] = np.isin(label[: len(outer)], label[len(outer) :])[of]
    return found

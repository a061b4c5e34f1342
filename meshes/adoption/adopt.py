"""Adopt a user's own part: its mesh in the finger's frame, and what of it was taken for what."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.meshes.adoption.roles import Asked, Roles
from dolfingrip.meshes.adoption.sizes import Measured, Wanted
from dolfingrip.meshes.measures import centroid
from dolfingrip.meshes.quality import Quality, check
from dolfingrip.meshes.solid import MeshError, SolidMesh

CAD: Final = (".step", ".stp", ".brep", ".iges", ".igs")
SURFACES: Final = (".stl", ".obj", ".ply")
MESHES: Final = (".msh", ".inp", ".vtk", ".vtu")


@dataclass(frozen=True, slots=True)
class Adopted:
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
    measured: Measured

    @property
    def size_mm(self) -> np.ndarray:
        """(3,) depth along x, width along y, length along z."""
        surface = self.roles.surface
        return np.asarray(np.ptp(surface.points[surface.triangles].reshape(-1, 3), axis=0))

    @property
    def centroid_x_mm(self) -> float:
        """The centre of gravity's distance from the back."""
        return float(centroid(self.mesh)[0])


def adopt(path: Path, asked: Asked, wanted: Wanted, scale: float = 1.0) -> Adopted:
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
        from dolfingrip.meshes.adoption.volume import adopt_mesh as make
    else:
        raise MeshError(f"{path}: unknown format; allowed: {', '.join((*CAD, *SURFACES, *MESHES))}")
    try:
        mesh, roles, measured = make(path, asked, wanted, scale)
        return Adopted(mesh, check(mesh), roles, measured)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None

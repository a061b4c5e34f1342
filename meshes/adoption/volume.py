"""A part from a mesh of elements, which stay as they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from dolfingrip.meshes import files, groups
from dolfingrip.meshes.adoption.facets import in_frame
from dolfingrip.meshes.adoption.roles import Asked, Roles, assign
from dolfingrip.meshes.adoption.sizes import Measured, Wanted, measured
from dolfingrip.meshes.adoption.sound import place
from dolfingrip.meshes.adoption.surface import Faces, segmented
from dolfingrip.meshes.measures import edge_lengths
from dolfingrip.meshes.solid import MeshError, SolidMesh, boundary, faces, labels


def adopt_mesh(
    path: Path, asked: Asked, wanted: Wanted, scale: float
) -> tuple[SolidMesh, Roles, Measured]:
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
    surface = replace(surface, face=segmented(surface.points, surface.triangles))
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
    found = replace(measured(roles, Wanted()), size_mm=size)
    return in_frame(replace(mesh, points=points, facets=facets), roles), roles, found


def _known(mesh: SolidMesh, outer: np.ndarray, of: np.ndarray) -> dict[str, np.ndarray]:
    """(m,) triangles of each group that the file has and that needs no guess."""
    found = {}
    for name, facets in mesh.facets.items():
        if name not in (groups.SKIN, groups.SYMMETRY) and len(facets):
            label = labels(np.concatenate([outer, facets]))
            found[name] = np.isin(label[: len(outer)], label[len(outer) :])[of]
    return found

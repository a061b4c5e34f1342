"""Gmsh's session, and meshes to and from its current model."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import gmsh
import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.solid import MeshError, SolidMesh, assemble

TET10: Final = np.array([0, 1, 2, 3, 4, 5, 6, 7, 9, 8])
"""Gmsh's order of a second-order tetrahedron's nodes in terms of ours, and the reverse."""

_OPTIONS: Final = {
    "General.Terminal": 0.0,
    "General.NumThreads": 1.0,  # meshes must not depend on the machine
    "Mesh.RandomSeed": 1.0,
}


@contextmanager
def session(about: str) -> Iterator[None]:
    """A Gmsh model of its own; everything is as it was before when the block is left.

    Parameters
    ----------
    about
        What is being done, for the error's line.

    Raises
    ------
    MeshError
        In place of Gmsh's own exceptions.
    """
    ours = not gmsh.isInitialized()
    before: dict[str, float] = {}
    if ours:
        # no interrupt handler, which only the main thread may set, and no user's settings
        gmsh.initialize([], readConfigFiles=False, interruptible=False)
    else:
        before = {name: gmsh.option.getNumber(name) for name in _OPTIONS}
        model_before = gmsh.model.getCurrent()
    try:
        for name, value in _OPTIONS.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("dolfingrip")
        yield
    except Exception as error:
        if type(error) is not Exception:  # Gmsh knows no other class
            raise
        lines = str(error).split("\n")
        raise MeshError(f"{about}: {lines[0]}") from None
    finally:
        if ours:
            gmsh.finalize()
        else:
            gmsh.model.remove()
            gmsh.model.setCurrent(model_before)
            for name, value in before.items():
                gmsh.option.setNumber(name, value)


def current_mesh() -> SolidMesh:
    """The mesh of the current Gmsh model, with those of our groups that it has.

    Raises
    ------
    MeshError
        Where there is no tetrahedron or elements of another shape or order are in the way.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max(initial=0)) + 1, -1, dtype=np.int64)
    index[tags.astype(np.int64)] = np.arange(len(tags))
    blocks = {}
    types, _, nodes = gmsh.model.mesh.getElements(3)
    for kind, node_tags in zip(types, nodes, strict=True):
        name, _, _, per_element, _, _ = gmsh.model.mesh.getElementProperties(kind)
        blocks[name] = index[node_tags.astype(np.int64)].reshape(-1, per_element)
    if len(blocks) != 1 or not set(blocks) <= {"Tetrahedron 4", "Tetrahedron 10"}:
        found = ", ".join(blocks) or "none"
        raise MeshError(f"volume elements: {found}; allowed: Tetrahedron 4 or Tetrahedron 10")
    tetrahedra = next(iter(blocks.values()))
    if tetrahedra.shape[1] == 10:
        tetrahedra = tetrahedra[:, TET10]
    triangles = {}
    for _, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(2, group)
        if name in groups.SURFACE_TAGS:
            triangles[name] = index[_triangles_of(group)]
    return assemble(coordinates.reshape(-1, 3), tetrahedra, triangles)


def _triangles_of(group: int) -> np.ndarray:
    """Tags of the corners of a physical group's triangles, shape (k, 3)."""
    corners = [np.empty((0, 3), dtype=np.int64)]
    for entity in gmsh.model.getEntitiesForPhysicalGroup(2, group):
        for kind, per_element in ((2, 3), (9, 6)):
            _, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
            corners.append(nodes.astype(np.int64).reshape(-1, per_element)[:, :3])
    return np.concatenate(corners)

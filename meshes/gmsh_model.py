"""Gmsh's session, and meshes to and from its current model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Final

import gmsh
import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.solid import MeshError, SolidMesh, assemble

_OPTIONS: Final = {
    "General.Terminal": 0.0,
    "General.NumThreads": 1.0,  # meshes must not depend on the machine
    "Mesh.RandomSeed": 1.0,
}


@contextmanager
def session(about: str, options: Mapping[str, float] | None = None) -> Iterator[None]:
    """A Gmsh model of its own; everything is as it was before when the block is left.

    Parameters
    ----------
    about
        What is being done, for the error's line.
    options
        Gmsh's numbers by name, for the block only.

    Raises
    ------
    MeshError
        In place of Gmsh's own exceptions.
    """
    options = {**_OPTIONS, **(options or {})}
    ours = not gmsh.isInitialized()
    before: dict[str, float] = {}
    if ours:
        # no interrupt handler, which only the main thread may set, and no user's settings
        gmsh.initialize([], readConfigFiles=False, interruptible=False)
    else:
        before = {name: gmsh.option.getNumber(name) for name in options}
        model_before = gmsh.model.getCurrent()
    try:
        for name, value in options.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("dolfingrip")
        yield
    except Exception as error:
        if type(error) is not Exception:  # Gmsh knows no other class
            raise
        raise MeshError(f"{about}: {str(error).splitlines()[0]}") from None
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
    triangles = {}
    for _, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(2, group).lower()
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


def insert(mesh: SolidMesh) -> None:
    """Put a mesh and its physical groups into the current, empty Gmsh model."""
    tags = np.arange(1, len(mesh.points) + 1)
    second = mesh.order == 2
    surfaces = [groups.SURFACE_TAGS[name] for name in mesh.facets]
    for surface in surfaces:
        gmsh.model.addDiscreteEntity(2, surface)
    gmsh.model.addDiscreteEntity(3, groups.SOLID_TAG, surfaces)
    gmsh.model.mesh.addNodes(3, groups.SOLID_TAG, tags, mesh.points.ravel())
    tetrahedra = (mesh.cells + 1).ravel()
    gmsh.model.mesh.addElementsByType(groups.SOLID_TAG, 11 if second else 4, [], tetrahedra)
    gmsh.model.addPhysicalGroup(3, [groups.SOLID_TAG], groups.SOLID_TAG, groups.SOLID)
    for (name, facets), surface in zip(mesh.facets.items(), surfaces, strict=True):
        gmsh.model.mesh.addElementsByType(surface, 9 if second else 2, [], (facets + 1).ravel())
        gmsh.model.addPhysicalGroup(2, [surface], surface, name)

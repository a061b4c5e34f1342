"""A session of Gmsh, and what its current model holds.

Meshes are converted to and from it, and files are read into it as data: neither Gmsh nor
OpenCASCADE reads what lies beside them. Solids of the OpenCASCADE kernel are bricks, tapered
bricks, and their unions and differences.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import gmsh
import numpy as np

from dolfingrip.loading import elsewhere
from dolfingrip.meshes import groups
from dolfingrip.meshes.solid import Floats, Ints, MeshError, SolidMesh, assemble, joined
from dolfingrip.sections.geometry.boxes import Box

_CELLS: Final = {4: 4, 11: 10, 5: 8, 17: 20}
_FACETS: Final = {2: 3, 9: 6, 3: 4, 16: 8}
"""Gmsh's types of elements and of facets, and the numbers of their nodes."""

_OPTIONS: Final = {
    "General.Terminal": 0.0,
    "General.NumThreads": 1.0,  # meshes must not depend on the machine
    "Mesh.RandomSeed": 1.0,
}


@contextmanager
def session(about: str, options: Mapping[str, float] | None = None) -> Iterator[None]:
    """A context with a new Gmsh model, which restores Gmsh's previous state.

    Args:
        about: the task, for the error's line.
        options: Gmsh's numbers by name, for the block only.

    Raises:
        MeshError: in place of Gmsh's own exceptions.
    """
    options = {**_OPTIONS, **(options or {})}
    ours = not gmsh.isInitialized()
    before: dict[str, float] = {}
    if ours:
        # without an interrupt handler, which only the main thread may set, and the user's settings
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
        if type(error) is not Exception:  # Gmsh raises no other class
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


_MESH: Final = b"$MeshFormat", b"$Comments"
"""What Gmsh takes a file for a mesh by, whole: it runs one with another content as a script."""


def open_mesh(path: Path) -> None:
    """Read a mesh file into the session, from a folder that has nothing else.

    Gmsh runs what it finds beside a file that it opens, as ``finger.msh.opt``.

    Args:
        path: a .msh file.

    Raises:
        MeshError: one line, where it is no mesh of Gmsh.
        OSError: where it cannot be read.
    """
    with TemporaryDirectory(prefix="dolfingrip-") as folder:
        alone = Path(folder, "alone.msh")
        shutil.copyfile(path, alone)
        with alone.open("rb") as file:
            if not file.read(len(_MESH[0])).startswith(_MESH):
                raise MeshError("not a mesh of Gmsh; allowed: a file that starts with $MeshFormat")
        gmsh.open(str(alone))


def import_shapes(path: Path, highest_only: bool = False) -> list[tuple[int, int]]:
    """Read the shapes of a CAD file into the model, without OpenCASCADE's settings of this folder.

    Args:
        path: a STEP, IGES or BREP file.
        highest_only: leave out shapes that bound others.

    Returns:
        Dimension and tag of each shape.
    """
    file = str(path.resolve())
    with elsewhere():
        return list(gmsh.model.occ.importShapes(file, highestDimOnly=highest_only))


def numbered_nodes() -> tuple[Floats, Ints]:
    """Places (n, 3) of the current Gmsh model's nodes, and the row of each by its tag."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.full(int(tags.max(initial=0)) + 1, -1, dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    return coordinates.reshape(-1, 3), row


def current_mesh() -> SolidMesh:
    """The mesh of the current Gmsh model, with the groups of :mod:`.groups` that it has.

    Raises:
        MeshError: where there are no tetrahedra or hexahedra, all of one order, or there are other
            elements.
    """
    points, index = numbered_nodes()
    blocks = {}
    types, numbers, nodes = gmsh.model.mesh.getElements(3)
    for kind, node_tags in zip(types, nodes, strict=True):
        per_element = gmsh.model.mesh.getElementProperties(kind)[3]
        blocks[kind] = index[node_tags.astype(np.int64)].reshape(-1, per_element)
    if len(blocks) != 1 or not set(blocks) <= set(_CELLS):
        names = [gmsh.model.mesh.getElementProperties(kind)[0] for kind in blocks]
        raise MeshError(
            f"volume elements: {', '.join(names) or 'none'}; allowed: one of Tetrahedron 4, "
            "Tetrahedron 10, Hexahedron 8 and Hexahedron 20 (Mesh.SecondOrderIncomplete)"
        )
    cells = next(iter(blocks.values()))
    facets = {}
    for _, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(2, group).lower()
        if groups.surface_tag(name) is not None:
            facets[name] = joined(name, [index[part] for part in _facets_of(group)], cells)
    regions = _regions(np.asarray(numbers[0], dtype=np.int64))
    return assemble(points, cells, facets, regions)


def _regions(numbers: Ints) -> dict[str, Ints]:
    """Rows of the elements of each volume group; the group of all elements is left out."""
    order = np.argsort(numbers)
    regions: dict[str, Ints] = {}
    for _, group in gmsh.model.getPhysicalGroups(3):
        name = gmsh.model.getPhysicalName(3, group).lower()
        if not name or name == groups.SOLID:
            continue
        entities = gmsh.model.getEntitiesForPhysicalGroup(3, group)
        parts = [t for entity in entities for t in gmsh.model.mesh.getElements(3, entity)[1]]
        members = np.concatenate([np.empty(0, np.int64), *parts]).astype(np.int64)
        regions[name] = np.sort(order[np.searchsorted(numbers, members, sorter=order)])
    return regions


def _facets_of(group: int) -> list[Ints]:
    """Tags of the nodes of a physical group's facets, arrays of shape (k, nodes)."""
    parts = []
    for entity in gmsh.model.getEntitiesForPhysicalGroup(2, group):
        for kind, per_element in _FACETS.items():
            _, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
            parts.append(nodes.astype(np.int64).reshape(-1, per_element))
    return parts


def insert(mesh: SolidMesh) -> None:
    """Put a mesh and its physical groups into the current, empty Gmsh model."""
    tags = np.arange(1, len(mesh.points) + 1)
    surfaces = [groups.surface_tag(name) for name in mesh.facets]
    for surface in surfaces:
        gmsh.model.addDiscreteEntity(2, surface)
    # an entity for each set of regions that some elements share
    names = list(mesh.regions)
    member = np.zeros((len(mesh.cells), len(names)), dtype=bool)
    for i, rows in enumerate(mesh.regions.values()):
        member[rows, i] = True
    kinds, of = np.unique(member, axis=0, return_inverse=True)
    volumes = [groups.SOLID_TAG + i for i in range(len(kinds))]
    kind = _type(_CELLS, mesh.cells)
    for i, volume in enumerate(volumes):
        gmsh.model.addDiscreteEntity(3, volume, surfaces)
        if not i:
            gmsh.model.mesh.addNodes(3, volume, tags, mesh.points.ravel())
        cells = mesh.cells[of.ravel() == i]
        gmsh.model.mesh.addElementsByType(volume, kind, [], (cells + 1).ravel())
    gmsh.model.addPhysicalGroup(3, volumes, groups.SOLID_TAG, groups.SOLID)
    for i, (name, tag) in enumerate(groups.volume_tags(names).items()):
        inside = [volume for volume, row in zip(volumes, kinds, strict=True) if row[i]]
        gmsh.model.addPhysicalGroup(3, inside, tag, name)
    for (name, facets), surface in zip(mesh.facets.items(), surfaces, strict=True):
        kind = _type(_FACETS, facets)
        gmsh.model.mesh.addElementsByType(surface, kind, [], (facets + 1).ravel())
        gmsh.model.addPhysicalGroup(2, [surface], surface, name)


def _type(types: Mapping[int, int], elements: Ints) -> int:
    """Gmsh's type of elements of shape (m, nodes)."""
    return next(kind for kind, nodes in types.items() if nodes == elements.shape[1])


Solids = list[tuple[int, int]]
"""Volumes of the current Gmsh model: their dimension, 3, and their tags."""


def brick(box: Box) -> Solids:
    """Add a box to the current Gmsh model.

    Args:
        box: extent along x, y and z (mm).
    """
    sizes = (high - low for low, high in box)
    return [(3, gmsh.model.occ.addBox(*(low for low, _ in box), *sizes))]


def tapered(box: Box, axis: int, root: int, slope: float) -> Solids:
    """Add a box to the current Gmsh model whose section shrinks along an axis.

    Half way it has the box's section.

    Args:
        box: extent along x, y and z (mm).
        axis: along which it is pulled.
        root: end of the axis with the largest section, 0 the lower one, 1 the upper one.
        slope: tangent of the angle of its sides.
    """
    sides = [other for other in range(3) if other != axis]
    by = slope * (box[axis][1] - box[axis][0]) / 2
    wires = []
    for end, at in enumerate(box[axis]):
        more = by if end == root else -by
        low, high = ([box[side][i] + (more if i else -more) for side in sides] for i in (0, 1))
        corners = []
        for u, v in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])):
            place = dict(zip((axis, *sides), (at, u, v), strict=True))
            corners.append(gmsh.model.occ.addPoint(place[0], place[1], place[2]))
        ends = zip(corners, corners[1:] + corners[:1], strict=True)
        wires.append(gmsh.model.occ.addWire([gmsh.model.occ.addLine(a, b) for a, b in ends]))
    return list(gmsh.model.occ.addThruSections(wires, makeSolid=True, makeRuled=True))


def fused(first: Solids, others: Solids) -> Solids:
    """Unite solids.

    Args:
        first, others: the solids, which are used up.
    """
    return list(gmsh.model.occ.fuse(first, others)[0]) if others else first


def less(solid: Solids, tools: Solids, *, keep: bool = False) -> Solids:
    """Take tools away from a solid.

    Args:
        solid: it is used up.
        tools: what is taken away.
        keep: whether the tools stay; they are used up otherwise.
    """
    return list(gmsh.model.occ.cut(solid, tools, removeTool=not keep)[0]) if tools else solid


def common(solid: Solids, other: Solids) -> Solids:
    """Keep what a solid shares with another one.

    Args:
        solid: it is used up.
        other: it stays.
    """
    return list(gmsh.model.occ.intersect(solid, other, removeTool=False)[0])


def volume_mm3(solids: Solids) -> float:
    """Return the volume of solids of the current Gmsh model.

    Args:
        solids: dimension and tag of each.
    """
    return sum(float(gmsh.model.occ.getMass(*solid)) for solid in solids)

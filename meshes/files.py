"""Read and write mesh files: Gmsh's .msh, Abaqus' .inp, and VTK's .vtk and .vtu."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import gmsh
import meshio
import numpy as np

from dolfingrip.files import whole, xml
from dolfingrip.meshes import abaqus, groups
from dolfingrip.meshes.cells import from_vtk, to_vtk
from dolfingrip.meshes.gmsh_model import current_mesh, insert, open_mesh, session
from dolfingrip.meshes.solid import Ints, MeshError, SolidMesh, assemble, joined

READABLE: Final = (".msh", ".inp", ".vtk", ".vtu")
WRITABLE: Final = (".msh", ".inp", ".vtk", ".vtu")

_CELLS: Final = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20}
_FACETS: Final = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8}
"""meshio's names of elements and of facets, and the numbers of their nodes."""


def read(path: Path, needed: Sequence[str] = groups.NEEDED) -> SolidMesh:
    """Read a mesh in mm with the groups of :mod:`dolfingrip.meshes.groups`.

    Args:
        path: A .msh file of Gmsh, the groups being its physical groups, an .inp file of Abaqus (see
            :mod:`dolfingrip.meshes.abaqus`), or a .vtk or .vtu file, the groups being the tags in
            the cells' array ``group``. Volume groups are regions: physical groups, element sets, or
            tags above 1 in the array, named as in ``groups.VOLUME_TAGS`` or ``region_7``.
        needed: groups that the mesh must have.

    Raises:
        MeshError: one line, if the file cannot be read or lacks a needed group.
    """
    if path.suffix.lower() not in READABLE:
        raise MeshError(f"mesh.file = {path}: unknown format; allowed: {', '.join(READABLE)}")
    readers = {".msh": _read_msh, ".inp": abaqus.read, ".vtk": _read_vtk, ".vtu": _read_vtk}
    try:
        mesh = readers[path.suffix.lower()](path)
    except OSError as error:
        raise MeshError(f"mesh.file = {path}: {error.strerror}") from None
    except MeshError as error:
        raise MeshError(f"mesh.file = {path}: {error}") from None
    except OverflowError:
        raise MeshError(f"mesh.file = {path}: a node's number is above 9.2e18") from None
    missing = [name for name in needed if not len(mesh.facets.get(name, ()))]
    if missing:
        raise MeshError(f"mesh.file = {path}: {groups.missing_message(missing)}")
    return mesh


def write(path: Path, mesh: SolidMesh) -> None:
    """Write a mesh in the format of the suffix, and read it back; an existing file is replaced.

    Args:
        path: file with the suffix .msh (4.1, text), .inp, .vtk or .vtu. The last two hold the tags
            of the groups of elements and facets as the cells' array ``group``.
        mesh: mesh in mm.

    Raises:
        MeshError: one line, if the suffix is another one.
        WriteError: one line, if the file cannot be written or is another mesh when read back.
    """
    suffix = path.suffix.lower()
    if suffix not in WRITABLE:
        raise MeshError(f"{path}: unknown format; allowed: {', '.join(WRITABLE)}")

    def same(written: Path) -> bool:
        return _counts(read(written, needed=())) == _counts(mesh)

    if suffix == ".inp":
        whole.write(path, abaqus.deck(mesh), check=same)
        return
    with whole.replacing(path, check=same) as (partial,):
        (_write_msh if suffix == ".msh" else _write_vtk)(partial, mesh)


def _counts(mesh: SolidMesh) -> tuple[int, int, dict[str, int]]:
    """Numbers of nodes, of elements, and of the facets of each group that has any."""
    facets = {name: len(rows) for name, rows in mesh.facets.items() if len(rows)}
    return len(np.unique(mesh.cells)), len(mesh.cells), facets


def _read_msh(path: Path) -> SolidMesh:
    with session("not readable"):
        open_mesh(path)
        return current_mesh()


def _read_vtk(path: Path) -> SolidMesh:
    # meshio.read itself ends the program where it finds no reader that works
    of_xml = path.suffix.lower() == ".vtu"
    reader = meshio.vtu.read if of_xml else meshio.vtk.read
    try:
        if of_xml:
            with path.open("rb") as file:
                xml.check_beginning(file)
        grid = reader(path)
    except OSError:
        raise
    except Exception as error:  # any error of the parser on a broken file
        raise MeshError(f"not readable as VTK: {error or type(error).__name__}") from None
    tags = grid.cell_data.get("group", [np.zeros(len(b.data), np.int64) for b in grid.cells])
    solids: list[Ints] = []
    volumes: list[Ints] = []
    facets: dict[str, list[Ints]] = defaultdict(list)
    for block, group in zip(grid.cells, tags, strict=True):
        data = np.asarray(block.data, dtype=np.int64)
        if block.type in _CELLS:
            solids.append(from_vtk(data))
            volumes.append(np.asarray(group, dtype=np.int64).ravel())
        elif block.dim == 3:
            solids.append(data)
        elif block.type in _FACETS:
            of = np.asarray(group).ravel()
            for tag in np.unique(of):
                if (name := groups.surface_name(int(tag))) is not None:
                    facets[name].append(data[of == tag])
    kinds = {block.type for block in grid.cells if block.dim == 3}
    if len(kinds) != 1 or not kinds <= set(_CELLS):
        raise MeshError(
            f"volume elements: {', '.join(sorted(kinds)) or 'none'}; "
            "allowed: tetrahedra or hexahedra, all of first or of second order"
        )
    cells = np.concatenate(solids)
    surfaces = {name: joined(name, parts, cells) for name, parts in facets.items()}
    present = {name: corners for name, corners in surfaces.items() if len(corners)}
    points = np.asarray(grid.points, dtype=float)
    names = {tag: name for name, tag in groups.VOLUME_TAGS.items()}
    tag_of = np.concatenate(volumes)
    regions = {
        names.get(tag, f"region_{tag}"): np.flatnonzero(tag_of == tag)
        for tag in sorted({int(tag) for tag in tag_of})
        if tag > groups.SOLID_TAG
    }
    return assemble(points, cells, present, regions)


def _write_msh(path: Path, mesh: SolidMesh) -> None:
    with session("not writable"):
        insert(mesh)
        gmsh.write(str(path))


def _write_vtk(path: Path, mesh: SolidMesh) -> None:
    solid = next(name for name, nodes in _CELLS.items() if nodes == mesh.cells.shape[1])
    of_facet = {nodes: name for name, nodes in _FACETS.items()}
    volume = np.full(len(mesh.cells), groups.SOLID_TAG, dtype=np.int32)
    for name, tag in groups.volume_tags(list(mesh.regions)).items():
        volume[mesh.regions[name]] = tag
    tags = [volume]
    tags += [np.full(len(f), groups.surface_tag(n), dtype=np.int32) for n, f in mesh.facets.items()]
    cells = [(solid, to_vtk(mesh.cells))]
    cells += [(of_facet[facets.shape[1]], facets) for facets in mesh.facets.values()]
    meshio.write(path, meshio.Mesh(mesh.points, cells, cell_data={"group": tags}))

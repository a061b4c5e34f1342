"""Meshes from and to files: Gmsh's .msh, Abaqus' .inp, and VTK's .vtk and .vtu."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import gmsh
import meshio
import numpy as np

from dolfingrip.meshes import abaqus, groups
from dolfingrip.meshes.gmsh_model import current_mesh, insert, session
from dolfingrip.meshes.solid import EXCHANGED, MeshError, SolidMesh

READABLE: Final = (".msh", ".inp")
WRITABLE: Final = (".msh", ".inp", ".vtk", ".vtu")


def read(path: Path) -> SolidMesh:
    """Read a mesh in mm with the groups of :mod:`dolfingrip.meshes.groups`.

    Parameters
    ----------
    path
        A .msh file of Gmsh, the groups being its physical groups, or an .inp file of
        Abaqus (see :mod:`dolfingrip.meshes.abaqus`).

    Raises
    ------
    MeshError
        Where the file cannot be read or lacks a needed group.
    """
    if path.suffix.lower() not in READABLE:
        raise MeshError(f"mesh.file = {path}: unknown format; allowed: {', '.join(READABLE)}")
    try:
        mesh = abaqus.read(path) if path.suffix.lower() == ".inp" else _read_msh(path)
    except OSError as error:
        raise MeshError(f"mesh.file = {path}: {error.strerror}") from None
    except MeshError as error:
        raise MeshError(f"mesh.file = {path}: {error}") from None
    missing = [name for name in groups.NEEDED if not len(mesh.facets.get(name, ()))]
    if missing:
        raise MeshError(f"mesh.file = {path}: {groups.missing_message(missing)}")
    return mesh


def write(path: Path, mesh: SolidMesh) -> None:
    """Write a mesh; the suffix tells the format, an existing file is replaced.

    Parameters
    ----------
    path
        With the suffix .msh (4.1, text), .inp, .vtk or .vtu. The last two hold the group
        tags of tetrahedra and facets as the cells' array ``group``.
    mesh
        In mm.

    Raises
    ------
    MeshError
        Where the suffix is another or the file cannot be written.
    """
    writers = {".msh": _write_msh, ".inp": abaqus.write, ".vtk": _write_vtk, ".vtu": _write_vtk}
    if path.suffix.lower() not in writers:
        raise MeshError(f"{path}: unknown format; allowed: {', '.join(WRITABLE)}")
    # a failure leaves no half-written file behind
    partial = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix.lower()}")
    try:
        partial.touch()
        writers[path.suffix.lower()](partial, mesh)
        partial.replace(path)
    except OSError as error:
        raise MeshError(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        partial.unlink(missing_ok=True)


def _read_msh(path: Path) -> SolidMesh:
    with path.open("rb") as file:
        start = file.read(9)
    # Gmsh would run anything else as a script
    if start != b"$MeshForm" and start != b"$Comments":
        raise MeshError("not a mesh of Gmsh; allowed: a file that starts with $MeshFormat")
    with session("not readable"):
        gmsh.open(str(path))
        return current_mesh()


def _write_msh(path: Path, mesh: SolidMesh) -> None:
    with session("not writable"):
        insert(mesh)
        gmsh.write(str(path))


def _write_vtk(path: Path, mesh: SolidMesh) -> None:
    solid, facet = ("tetra", "triangle") if mesh.order == 1 else ("tetra10", "triangle6")
    tags = [np.full(len(mesh.tetrahedra), groups.SOLID_TAG, dtype=np.int32)]
    tags += [
        np.full(len(f), groups.SURFACE_TAGS[n], dtype=np.int32) for n, f in mesh.facets.items()
    ]
    tetrahedra = mesh.tetrahedra if mesh.order == 1 else mesh.tetrahedra[:, EXCHANGED]
    cells = [(solid, tetrahedra), *((facet, facets) for facets in mesh.facets.values())]
    meshio.write(path, meshio.Mesh(mesh.points, cells, cell_data={"group": tags}))

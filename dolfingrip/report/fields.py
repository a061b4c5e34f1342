"""Fields of a run: the ParaView collection, its steps and the pressures they belong to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from dolfingrip.channels import FIELDS, MOVED
from dolfingrip.files import xml
from dolfingrip.files.table import Columns, branches, read_csv, required
from dolfingrip.meshes import vtk_file
from dolfingrip.meshes.cells import from_vtk

STEP_FILES: Final = (".vtu", ".pvtu")
"""Files that a collection may name. pyvista chooses a reader by the ending, and its older versions
unpickle what ends in .pkl."""

TOLERANCE_KPA = 1e-3
"""Pressures closer than this are the same: files round what the solver reaches exactly."""

CELL_TYPES: Final = [({10, 24, 71}, (4, 10)), ({12, 25, 72}, (8, 20, 27))]
"""VTK's types of tetrahedra and of hexahedra, and the nodes of those of order 1 and 2.

Linear, quadratic, and Lagrange, which is what dolfinx writes, whatever the degree.
"""

FACE_MIDDLES: Final = (24, 25, 22, 21, 23, 20)
"""Nodes in the middles of a Lagrange hexahedron's faces, in the order of ``HEXAHEDRON.faces``."""

Floats = npt.NDArray[np.float64]
_MANY_COMPONENTS: Final = re.compile(rb'NumberOfComponents="(?![1-9]")[^"]{0,9}')

FARTHEST_MM: Final = 1e6
"""Distance within which all places of a body lie."""

GHOST = 1
"""VTK's flag of a cell or point that another piece owns."""


@dataclass(frozen=True)
class FieldMesh:
    """A mesh of tetrahedra or hexahedra with each node once, whatever the number of pieces on disk.

    Attributes:
        points: reference positions in mm, shape (nodes, 3).
        cells: node numbers of tetrahedra, shape (cells, 4) or (cells, 10), or of hexahedra, shape
            (cells, 8), (cells, 20) or (cells, 27), in the order of
            :class:`~dolfingrip.meshes.solid.SolidMesh`. 27 nodes include the faces' middles, in
            the order of the element's faces, and then the middle of the element.
        source: row of each node in the file's point arrays, shape (nodes,).
    """

    points: npt.NDArray[np.float64]
    cells: npt.NDArray[np.int64]
    source: npt.NDArray[np.int64]


def list_steps(collection: Path) -> list[Path]:
    """Files of a ``.pvd`` collection, one per step, in the order written.

    The entries are taken in their order and not by their times, so that two steps at the
    same time stay two steps.

    Raises:
        ValueError: One line where the file is missing, is no collection, or is empty.
    """
    try:
        root = xml.parse(collection.read_bytes())
    except OSError as error:
        raise ValueError(f"{collection}: {error.strerror}") from None
    except xml.XmlError as error:
        raise ValueError(f"{collection}: not a ParaView collection: {error}") from None
    files = [collection.parent / str(entry.get("file")) for entry in root.iter("DataSet")]
    if not files:
        raise ValueError(f"{collection}: holds no steps")
    for file in files:  # a folder that was received reads nothing of the one who opens it
        if not file.resolve().is_relative_to(collection.parent.resolve()):
            raise ValueError(f"{collection}: {file}: allowed: files of its own folder")
        if file.suffix not in STEP_FILES:
            raise ValueError(f"{collection}: {file}: allowed: {', '.join(STEP_FILES)}")
    return files


def find_steps(
    result: Columns, pressures_kPa: Sequence[float], branch: str = "loading"
) -> list[int]:
    """Row numbers of a result at the pressures asked for.

    Args:
        result: columns with ``pressure_kPa`` and, where pressure also falls, ``branch``.
        pressures_kPa: Pressures wanted, each one a row of the result.
        branch: branch of the row; the first such row at a pressure is taken, or the first of any
            branch if this one never has the pressure.

    Raises:
        ValueError: One line naming a pressure asked for that is not in the results, and those that
            are.
    """
    reached_kPa = required(result, "pressure_kPa")
    candidates = np.flatnonzero(branches(result) == branch)
    if candidates.size == 0:
        known_branches = ", ".join(dict.fromkeys(branches(result)))
        raise ValueError(f"branch = {branch}: allowed: {known_branches}")
    steps = []
    for p_kPa in pressures_kPa:
        there = np.flatnonzero(np.abs(reached_kPa - p_kPa) <= TOLERANCE_KPA)
        near = np.concatenate([there[np.isin(there, candidates)], there])
        if near.size == 0:
            available = ", ".join(f"{p:g}" for p in dict.fromkeys(reached_kPa))
            raise ValueError(f"pressure_kPa = {p_kPa:g}: not in the results; allowed: {available}")
        steps.append(int(near[0]))
    return steps


def load_result(collection: Path, result: Columns | Path | None) -> Columns:
    """The result of a collection: the one given, or ``result.csv`` in the collection's folder."""
    if result is None:
        result = collection.parent / "result.csv"
    if not isinstance(result, Path):
        return result
    try:
        return read_csv(result, ours=True)
    except OSError as error:
        raise ValueError(f"{result}: {error.strerror}") from None


def read_grid(file: Path) -> Any:
    """One step as a pyvista grid.

    Raises:
        ValueError: One line where the file is missing or damaged.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror}") from None
    if many := _MANY_COMPONENTS.search(content):  # VTK takes memory for as many as there are told
        raise ValueError(f"{file}: damaged: {many[0].decode(errors='replace')}")
    try:
        grid = vtk_file.read(file)
    except xml.XmlError as error:
        raise ValueError(f"{file}: damaged: {error}") from None
    if not grid.n_cells or not _near(grid.points):
        raise ValueError(f"{file}: damaged: no elements, or points that are no numbers")
    nodes = np.asarray(grid.cell_connectivity)
    if nodes.min() < 0 or nodes.max() >= grid.n_points:
        raise ValueError(f"{file}: damaged: elements with nodes that it has not")
    return grid


def _near(places_mm: Any) -> bool:
    """Return whether places are numbers that a body can have."""
    return bool((np.abs(places_mm) < FARTHEST_MM).all())


def read_mesh(grid: Any) -> FieldMesh:
    """Join the pieces of a grid of linear or quadratic tetrahedra or hexahedra.

    Args:
        grid: A pyvista unstructured grid, positions in mm.

    Raises:
        ValueError: One line where the grid holds anything but linear or quadratic tetrahedra or
            hexahedra, all of one shape and order.
    """
    types = set(np.unique(grid.celltypes).tolist())
    sizes = np.unique(np.diff(grid.cell_offsets))
    allowed = any(types <= kinds and set(sizes) <= set(nodes) for kinds, nodes in CELL_TYPES)
    if sizes.size != 1 or not allowed:
        raise ValueError(
            f"fields: VTK cell types {sorted(types)} of {sizes.tolist()} nodes; "
            "allowed: linear or quadratic tetrahedra or hexahedra"
        )
    connectivity = np.asarray(grid.cell_connectivity, dtype=np.int64).reshape(-1, sizes[0])
    cells = from_vtk(connectivity[:, :20])
    if sizes[0] == 27:
        cells = np.hstack([cells, connectivity[:, [*FACE_MIDDLES, 26]]])
    if "vtkGhostType" in grid.cell_data:
        cells = cells[(np.asarray(grid.cell_data["vtkGhostType"]) & GHOST) == 0]
    source, merged = _merge(grid)
    cells = merged[cells]
    used, renumbered = np.unique(cells, return_inverse=True)
    points = np.asarray(grid.points, dtype=np.float64)[source[used]]
    return FieldMesh(points, renumbered.reshape(cells.shape).astype(np.int64), source[used])


def read_point_data(grid: Any, name: str, source: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """A point array at the joined nodes, shape (nodes,) or (nodes, 3).

    Raises:
        ValueError: One line naming the missing array and those there are.
    """
    if name not in grid.point_data:
        raise ValueError(f"fields: no point data {name}; there are {', '.join(grid.point_data)}")
    return np.asarray(grid.point_data[name], dtype=np.float64)[source]


def read_steps(files: Sequence[Path]) -> tuple[FieldMesh, list[Floats], dict[str, list[Floats]]]:
    """Read the fields of steps.

    Args:
        files: of the steps, one or more.

    Returns:
        The mesh at rest; for each step displacements (mm), shape (nodes, 3); and by the name of
        each further field that the files have, its values, shape (nodes,), for each step.

    Raises:
        ValueError: one line, if a file is missing or holds something else, or meshes differ.
    """
    mesh: FieldMesh | None = None
    displacements, points = [], 0
    further: dict[str, list[Floats]] = {}
    for file in files:
        grid = read_grid(file)
        if mesh is None:
            mesh, points = read_mesh(grid), grid.n_points
        if grid.n_points != points:
            raise ValueError(f"{file.parent}: steps on different meshes")
        displacements.append(read_point_data(grid, MOVED.array, mesh.source))
        if not _near(displacements[-1]):
            raise ValueError(f"{file}: damaged: displacements that are no numbers")
        for name, field in FIELDS.items():
            if field is not MOVED and field.array in grid.point_data:
                values = read_point_data(grid, field.array, mesh.source)
                further.setdefault(name, []).append(values)
    assert mesh is not None
    return mesh, displacements, {k: v for k, v in further.items() if len(v) == len(displacements)}


def _merge(grid: Any) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Rows of the distinct points, and for each point the number of its distinct one."""
    points = np.asarray(grid.points, dtype=np.float64)
    extent = float(np.ptp(points, axis=0).max())
    # An irrational shift keeps positions such as 0.5 mm off the borders between two roundings.
    keys = np.round(points / (1e-7 * extent) + 0.2360679775).astype(np.int64)
    order: npt.NDArray[np.int64] = np.arange(len(points))
    if "vtkGhostType" in grid.point_data:
        # Owned points come first: values of ghosts are stale unless they were updated.
        order = np.argsort(np.asarray(grid.point_data["vtkGhostType"]) & GHOST, kind="stable")
    _, first, inverse = np.unique(keys[order], axis=0, return_index=True, return_inverse=True)
    merged = np.empty(len(points), dtype=np.int64)
    merged[order] = inverse.reshape(-1)
    return order[first].astype(np.int64), merged

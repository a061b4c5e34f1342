"""A solid of finite elements with named groups of boundary facets, its surfaces and its copies.

A surface is an array of rows of :func:`faces`, so it knows the cells on one of its sides. Several
solids stand in one mesh without shared nodes: in place, or as copies side by side.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from dolfingrip.meshes.cells import BY_NODES, FACET_CORNERS, CellShape, Floats, Ints
from dolfingrip.meshes.groups import SYMMETRY
from dolfingrip.sections.errors import ConfigError

ON_PLANE: Final = 1e-5
"""Distance from a plane, relative to a mesh's extent, up to which a point lies in it."""

MOST_ELEMENTS: Final = 10_000_000
"""Largest number of elements; larger meshes do not fit into memory."""


class MeshError(ConfigError):
    """One line about a mesh that cannot be made, read or used."""


@dataclass(frozen=True, slots=True)
class SolidMesh:
    """A mesh of elements of one shape and order, with the facets of each surface group.

    Attributes:
        points: coordinates in mm, shape (n, 3).
        cells: node indices: of tetrahedra, shape (m, 4) or (m, 10), or of hexahedra, shape (m, 8)
            or (m, 20); corners first, then the midpoints of the edges, in Gmsh's order (see
            :class:`~dolfingrip.meshes.cells.CellShape`). VTK, Abaqus and meshio have another order
            of the midpoints, see :func:`~dolfingrip.meshes.cells.to_vtk`.
        facets: node indices of each surface group's triangles, shape (k, 3) or (k, 6), or
            quadrilaterals, shape (k, 4) or (k, 8): corners counter-clockwise seen from outside the
            solid (normals point out of it, into the cavity on the cavity's surface), then the
            midpoints of the edges from each corner to the next.
        regions: rows of ``cells`` of each volume group; empty if the solid has none. They may
            overlap or leave cells out.
    """

    points: Floats
    cells: Ints
    facets: dict[str, Ints]
    regions: dict[str, Ints] = field(default_factory=dict)

    @property
    def shape(self) -> CellShape:
        """Shape of the elements."""
        return BY_NODES[self.cells.shape[1]]

    @property
    def order(self) -> int:
        """Order of the elements, 1 or 2."""
        return self.shape.order(self.cells.shape[1])


def faces(cells: Ints) -> Ints:
    """All faces of all cells, seen from outside; face ``f`` of cell ``c`` is row ``faces · c + f``.

    Args:
        cells: as in :class:`SolidMesh`, shape (m, nodes).

    Returns:
        Shape (m · faces, nodes of a facet).
    """
    shape = BY_NODES[cells.shape[1]]
    nodes = shape.facet_corners * shape.order(cells.shape[1])
    return cells[:, shape.faces[:, :nodes]].reshape(-1, nodes)


def labels(facets: Ints) -> Ints:
    """A number from 0 on for each facet, shape (k,); facets with equal corners have equal numbers.

    Args:
        facets: node indices, corners first and in any order, shape (k, nodes).
    """
    corners = np.sort(facets[:, : FACET_CORNERS[facets.shape[1]]], axis=1)
    order = np.lexsort(corners.T)
    new = np.ones(len(corners), dtype=np.int64)
    new[1:] = (np.diff(corners[order], axis=0) != 0).any(axis=1)
    numbers = np.empty(len(corners), dtype=np.int64)
    numbers[order] = np.cumsum(new) - 1
    return numbers


def parts_of(links: Ints, count: int) -> Ints:
    """Number of the connected part of each item, (count,).

    Args:
        links: (k, 2) items that are connected.
        count: number of items.
    """
    graph = sp.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), (count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def boundary(cells: Ints) -> Ints:
    """Faces that only one cell has.

    Args:
        cells: (n, nodes) nodes of the cells.

    Returns:
        Rows of :func:`faces`, shape (k,).
    """
    label = labels(faces(cells))
    return np.flatnonzero(np.bincount(label)[label] == 1)


def match(facets: Ints, cells: Ints) -> Ints:
    """Boundary face of each facet: a row of :func:`faces`, or -1 if there is none.

    Args:
        facets: node indices, corners first and in any order, shape (k, nodes).
        cells: as in :class:`SolidMesh`.

    Returns:
        Shape (k,).
    """
    rows = boundary(cells)
    corners = BY_NODES[cells.shape[1]].facet_corners
    label = labels(np.concatenate([faces(cells)[rows, :corners], facets[:, :corners]]))
    row_of = np.full(len(label), -1, dtype=np.int64)
    row_of[label[: len(rows)]] = rows
    return row_of[label[len(rows) :]]


def joined(name: str, parts: Sequence[Ints], cells: Ints) -> Ints:
    """Corners of a group's facets, shape (k, corners).

    Args:
        name: name of the group, for the error.
        parts: node indices of facets of any order, shape (·, nodes).
        cells: as in :class:`SolidMesh`.

    Raises:
        MeshError: if facets have not the shape of the elements' faces.
    """
    shape = BY_NODES[cells.shape[1]]
    for part in parts:
        if len(part) and FACET_CORNERS[part.shape[1]] != shape.facet_corners:
            raise MeshError(
                f"group {name}: facets of {FACET_CORNERS[part.shape[1]]} corners on "
                f"{shape.plural}; allowed: {shape.facet_name}s"
            )
    present = [part[:, : shape.facet_corners] for part in parts if len(part)]
    return np.concatenate([np.empty((0, shape.facet_corners), dtype=np.int64), *present])


def _rows(name: str, facets: Ints, cells: Ints) -> Ints:
    """Rows of :func:`faces` of a group's facets; each facet must be a face."""
    rows = match(facets, cells)
    if (rows < 0).any():
        raise MeshError(f"group {name}: {(rows < 0).sum()} facets not on the solid's surface")
    return rows


def assemble(
    points: Floats,
    cells: Ints,
    facets: dict[str, Ints],
    regions: Mapping[str, Ints] | None = None,
) -> SolidMesh:
    """A mesh from facets of any orientation; points that no element has are left out.

    Args:
        points: shape (n, 3), mm.
        cells: as in :class:`SolidMesh`.
        facets: corners of each group's facets first, shape (k, nodes).
        regions: as in :class:`SolidMesh`.

    Raises:
        MeshError: where a facet is no face on the boundary of the solid, or an element has a node
            that is not there.
    """
    for numbers in (cells, *facets.values()):
        for node in (numbers.min(initial=0), numbers.max(initial=0)):
            if not 0 <= node < max(len(points), 1):
                raise MeshError(f"node {node} of an element: allowed: 0 to {len(points) - 1}")
    used, inverse = np.unique(cells, return_inverse=True)
    new = np.full(len(points), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    compact = inverse.reshape(cells.shape).astype(np.int64)
    every = faces(compact)
    corners = BY_NODES[cells.shape[1]].facet_corners
    groups = {}
    for name, group in facets.items():
        groups[name] = every[np.unique(_rows(name, new[group[:, :corners]], compact))]
    return SolidMesh(np.ascontiguousarray(points[used]), compact, groups, dict(regions or {}))


def second_order(mesh: SolidMesh) -> SolidMesh:
    """A first-order mesh with a node in the middle of each straight edge.

    The old points come first and keep their numbers; elements and facets keep their order.

    Args:
        mesh: mesh of first order (mm).

    Returns:
        The mesh of second order (mm).

    Raises:
        MeshError: where the mesh is of second order, or a facet is no face on the boundary of the
            solid.
    """
    if mesh.order != 1:
        raise MeshError(f"mesh: {mesh.shape.plural} of order {mesh.order}; allowed: order 1")
    ends = np.sort(mesh.cells[:, mesh.shape.edges], axis=2).reshape(-1, 2)
    edges, row = np.unique(ends, axis=0, return_inverse=True)
    middles = len(mesh.points) + row.reshape(len(mesh.cells), -1)
    cells = np.hstack([mesh.cells, middles])
    every = faces(cells)
    groups = {name: every[_rows(name, facets, cells)] for name, facets in mesh.facets.items()}
    points = np.concatenate([mesh.points, mesh.points[edges].mean(axis=1)])
    return SolidMesh(points, cells, groups, mesh.regions)


def mirrored(half: SolidMesh) -> SolidMesh:
    """Make a whole solid from its half y ≥ 0.

    Args:
        half: mesh with the group ``symmetry``, whose nodes both halves share (mm).

    Returns:
        The mesh of both halves (mm), with the groups and regions of both and without the group
        ``symmetry``.
    """
    count, nodes = len(half.points), half.cells.shape[1]
    shared = np.unique(half.facets[SYMMETRY])
    image = count + np.arange(count)
    image[shared] = shared  # what is then unused, `assemble` leaves out
    return assemble(
        np.vstack([half.points, half.points * [1.0, -1.0, 1.0]]),
        np.vstack([half.cells, image[half.cells[:, half.shape.mirror[:nodes]]]]),
        {n: np.vstack([f, image[f]]) for n, f in half.facets.items() if n != SYMMETRY},
        all_rows([half.regions] * 2, [len(half.cells)] * 2),
    )


def face_rows(mesh: SolidMesh, cells: Ints) -> Ints:
    """Rows of all faces of these cells, shape (len(cells) · faces,)."""
    count = len(mesh.shape.faces)
    rows: Ints = (cells[:, None] * count + np.arange(count)).ravel()
    return rows


def on_plane(mesh: SolidMesh, cells: Ints, *, highest: bool) -> Ints:
    """Faces of cells in the lowest or highest plane x = const that they reach.

    Args:
        mesh: mesh of the finger.
        cells: rows of the mesh's cells.
        highest: the front, towards +x, instead of the back.

    Returns:
        Rows of :func:`~dolfingrip.meshes.solid.faces`, shape (k,).

    Raises:
        MeshError: if no face lies in that plane.
    """
    rows = face_rows(mesh, cells)
    corners = mesh.shape.facet_corners
    x = mesh.points[faces(mesh.cells)[rows, :corners], 0]
    level = x.max() if highest else x.min()
    tolerance = ON_PLANE * float(np.ptp(mesh.points, axis=0).max())
    in_plane: Ints = rows[(np.abs(x - level) <= tolerance).all(axis=1)]
    if not len(in_plane):
        raise MeshError(f"no face of an element lies in the plane x = {level:.4g} mm")
    return in_plane


def interface(mesh: SolidMesh, one: Ints, other: Ints) -> Ints:
    """Faces that some cells share with others.

    Args:
        mesh: mesh of the finger.
        one: rows of cells.
        other: rows of other cells.

    Returns:
        Rows of :func:`~dolfingrip.meshes.solid.faces`, shape (k,).

    Raises:
        MeshError: if they share none.
    """
    every, corners = faces(mesh.cells), mesh.shape.facet_corners
    here, there = face_rows(mesh, np.setdiff1d(one, other)), face_rows(mesh, other)
    label = labels(np.concatenate([every[here, :corners], every[there, :corners]]))
    shared: Ints = here[np.isin(label[: len(here)], label[len(here) :])]
    if not len(shared):
        raise MeshError("the two regions have no face in common")
    return shared


def of_group(mesh: SolidMesh, name: str) -> Ints:
    """Faces of a surface group.

    Args:
        mesh: mesh of the finger.
        name: name of a surface group.

    Returns:
        Rows of :func:`~dolfingrip.meshes.solid.faces`, shape (k,).

    Raises:
        MeshError: if there is no such group.
    """
    if name not in mesh.facets:
        raise MeshError(f"no such group; allowed: {', '.join(mesh.facets)}")
    return match(mesh.facets[name], mesh.cells)


APART: float = 0.5
"""Space between copies, as a part of the solid's depth."""


def merged(solids: Sequence[SolidMesh]) -> SolidMesh:
    """Solids that share no node, as one mesh.

    A surface group has the facets of all solids that have it. A region has their cells.

    Raises:
        MeshError: one line, if their elements differ.
    """
    kinds = [f"{solid.shape.plural} of order {solid.order}" for solid in solids]
    if len(set(kinds)) > 1:
        raise MeshError(f"solids: {', '.join(kinds)}; allowed: elements of one shape and order")
    counts = [len(solid.points) for solid in solids]
    first = np.cumsum([0, *counts])
    points = np.concatenate([solid.points for solid in solids])
    cells = np.concatenate([s.cells + start for s, start in zip(solids, first, strict=False)])
    facets = all_rows([s.facets for s in solids], counts)
    regions = all_rows([s.regions for s in solids], [len(s.cells) for s in solids])
    return SolidMesh(points, cells, facets, regions)


def side_by_side(solids: Sequence[SolidMesh]) -> SolidMesh:
    """Put several solids into one mesh.

    Args:
        solids: meshes of one depth (mm).

    Returns:
        One mesh; each solid is shifted along x by 1 + :data:`APART` depths from the one
        before.
    """
    shift = np.array([(1 + APART) * float(np.ptp(solids[0].points[:, 0])), 0.0, 0.0])
    shifted = [replace(solid, points=solid.points + i * shift) for i, solid in enumerate(solids)]
    return merged(shifted)


def all_rows(solids: Sequence[Mapping[str, Ints]], counts: Sequence[int]) -> dict[str, Ints]:
    """Rows of each name in all solids, which are put one after the other.

    Args:
        solids: for each solid, rows of its points, cells or faces of cells, by name.
        counts: number of these in each solid.
    """
    by_name: dict[str, list[Ints]] = {}
    for rows, start in zip(solids, np.cumsum([0, *counts]), strict=False):
        for name, members in rows.items():
            by_name.setdefault(name, []).append(members + start)
    return {name: np.concatenate(rows) for name, rows in by_name.items()}


def shares(low_mm: float, high_mm: float, count: int) -> tuple[float, float]:
    """Shift from one copy to the next, and the x at which the first copy's share begins.

    Args:
        low_mm: smallest x of all copies.
        high_mm: largest x of all copies.
        count: number of copies.
    """
    depth = (high_mm - low_mm) / (1 + (count - 1) * (1 + APART))
    return (1 + APART) * depth, low_mm - APART / 2 * depth

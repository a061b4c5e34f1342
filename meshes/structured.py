"""Solids of boxes in hexahedra: cells of a rectilinear grid.

Reduced-integration serendipity elements of second order (Abaqus' C3D20R) bend well with one cell
across a wall, so such a mesh is as accurate as tetrahedra with several times as many unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dolfingrip.meshes import groups
from dolfingrip.meshes.cells import Ints
from dolfingrip.meshes.dimensions import own, refuse_slivers
from dolfingrip.meshes.solid import MOST_ELEMENTS, Floats, MeshError, SolidMesh, faces, second_order
from dolfingrip.sections.geometry.boxes import THINNEST_MM, Box, BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.specimen import Mesh

Bools = NDArray[np.bool_]

SOLID, CAVITY, OUTSIDE = 0, 1, 2
"""Kinds of cells of the grid."""

NEIGHBOUR: Final = ((2, 0), (2, 1), (1, 0), (0, 1), (1, 1), (0, 0))
"""Axis and side (0: low, 1: high) of each face of a hexahedron."""


RATIO: Final = 7.0
"""Of neighbouring cells' sizes away from a concave edge; the stress decays as r^-0.46."""

RATIO_IN_WALLS: Final = 5.0
"""Of cells that grow into a thick wall, within which strain decays."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Planes of a rectilinear grid and the kind of its cells.

    Attributes:
        planes: coordinates (mm) along x, y and z, ascending, shapes (n + 1,).
        kind: :data:`SOLID`, :data:`CAVITY` or :data:`OUTSIDE` of each cell, shape (nx, ny, nz).
        regions: for each region, whether each cell is in it, shape (nx, ny, nz); no
            cell is in two regions. Empty for a solid of one region.
        cup_mm: length along z over which the sides are also clamped.
    """

    planes: tuple[Floats, Floats, Floats]
    kind: Ints
    regions: Mapping[str, Bools] = field(default_factory=dict)
    cup_mm: float = 0.0


def structured_mesh(dimensions: Geometry, mesh: Mesh) -> SolidMesh:
    """Mesh a finger in hexahedra.

    Args:
        dimensions: dimensions of a finger of any kind of geometry.
        mesh: whether half or whole, sizes, refinement.

    Returns:
        Hexahedra with straight edges, points in mm.

    Raises:
        MeshError: if a part of the finger is too thin, or the mesh would not fit into memory.
    """
    refuse_slivers(dimensions)
    solid = _cells(grid(dimensions.alike(), mesh), mesh.half)
    if (place := own(dimensions)) is not None:
        solid = replace(solid, points=place(solid.points))
    return second_order(solid) if mesh.order == 2 else solid


def grid(dimensions: Geometry, mesh: Mesh) -> Grid:
    """A grid refined towards concave edges; all faces of the finger lie in its planes."""
    size, edge = mesh.hexahedra_mm(dimensions)
    boxes = dimensions.solid()
    assert isinstance(boxes, BoxSolid)  # no other solid is meshed in hexahedra
    walls = [_unique(boxes.planes(axis)) for axis in range(3)]
    if mesh.half:
        walls[1] = walls[1][walls[1] > -THINNEST_MM]
        walls[1] = np.concatenate([[0.0], walls[1][walls[1] > THINNEST_MM]])
    _limit(boxes.body, mesh, size, edge)
    marks = [boxes.graded(axis, both_sides=mesh.both_sides) for axis in range(3)]
    growth = RATIO_IN_WALLS if mesh.both_sides else RATIO
    planes = [
        _planes(walls[axis], marks[axis], (size, edge, growth), mesh.refine) for axis in range(3)
    ]
    return Grid(
        (planes[0], planes[1], planes[2]),
        _labels(planes, ((OUTSIDE, boxes.gaps), (CAVITY, boxes.cavity))),  # else SOLID
        _regions(planes, boxes),
        boxes.cup_mm,
    )


def _limit(body: Box, mesh: Mesh, size: float, edge: float) -> None:
    """Refuse sizes that would fill the memory, before anything is allocated."""
    x, y, z = (high - low for low, high in body)
    extent = (x, y / (2 if mesh.half else 1), z)
    expected = mesh.refine**3 * math.prod(max(length / size, 1.0) for length in extent)
    if expected > MOST_ELEMENTS:
        least = size * (expected / MOST_ELEMENTS) ** (1 / 3)
        raise MeshError(
            f"mesh.size_mm = {size}: about {expected:.0e} hexahedra; "
            f"allowed: at least {least:.2g} mm for this finger"
        )
    if edge > size:
        raise MeshError(
            f"mesh.edge_size_mm = {edge}: allowed: above 0 and up to size_mm = {size:g} mm"
        )


def _unique(values: Iterable[float]) -> Floats:
    """Sorted coordinates; coordinates closer than :data:`THINNEST_MM` / 10 become one."""
    ordered = np.unique(np.fromiter(values, dtype=float))
    keep = np.concatenate([[True], np.diff(ordered) > THINNEST_MM / 10])
    return ordered[keep]


def _planes(
    walls: Floats,
    marks: tuple[Sequence[float], Sequence[float]],
    sizes: tuple[float, float, float],
    refine: int,
) -> Floats:
    """Coordinates on and between ``walls``, fine above the first ``marks`` and below the second.

    ``sizes`` are the largest cell (mm), the cell at marks (mm), and the ratio of neighbours.
    """

    def among(value: float, marked: Sequence[float]) -> bool:
        return any(abs(value - other) < THINNEST_MM / 10 for other in marked)

    lengths: list[float] = []
    for start, end in pairwise(walls):
        ends = among(start, marks[0]), among(end, marks[1])
        lengths += _divide(float(end - start), sizes, ends)
    fine = np.repeat(np.array(lengths) / refine, refine)
    planes = walls[0] + np.concatenate([[0.0], np.cumsum(fine)])
    # exactly on the walls, so that symmetry plane, clamp and tip are exact
    nearest = np.abs(planes[:, None] - walls).argmin(axis=0)
    planes[nearest] = walls
    return planes


def _divide(
    length: float, sizes: tuple[float, float, float], ends: tuple[bool, bool]
) -> list[float]:
    """Lengths of the cells of one interval, graded from its marked ends."""
    size, edge, growth = sizes
    head: list[float] = []
    tail: list[float] = []
    remaining = length
    next_head, next_tail = (edge if marked else math.inf for marked in ends)
    while min(next_head, next_tail) < remaining / 2:
        if next_head <= next_tail:
            head.append(next_head)
            remaining -= next_head
            next_head = min(next_head * growth, size)
        else:
            tail.append(next_tail)
            remaining -= next_tail
            next_tail = min(next_tail * growth, size)
    count = max(1, math.ceil(remaining / size - 1e-9))
    return [*head, *[remaining / count] * count, *reversed(tail)]


def _labels(planes: list[Floats], labelled: Iterable[tuple[int, Sequence[Box]]]) -> Ints:
    """Label of each cell of the grid by the boxes that it is in, the last ones first; 0 of none."""
    label = np.zeros([len(p) - 1 for p in planes], dtype=np.int64)
    for number, boxes in labelled:
        for box in boxes:
            label[_within(planes, box)] = number
    return label


def _regions(planes: list[Floats], boxes: BoxSolid) -> dict[str, Bools]:
    """Cells of the grid that are in each region, by name, as arrays of bool."""
    if not boxes.regions:
        return {}
    names = [boxes.rest, *boxes.regions]
    label = _labels(planes, enumerate(boxes.regions.values(), 1))
    return {name: label == i for i, name in enumerate(names)}


def _within(planes: list[Floats], box: Box) -> tuple[Ints, ...]:
    """Index of the cells whose middle lies in a box."""
    centres = [(p[1:] + p[:-1]) / 2 for p in planes]
    return np.ix_(
        *[
            np.flatnonzero((c > low) & (c < high))
            for c, (low, high) in zip(centres, box, strict=True)
        ]
    )


def _cells(grid: Grid, half: bool) -> SolidMesh:
    """The solid cells of a grid with their groups."""
    shape = np.array(grid.kind.shape)
    number = np.arange(np.prod(shape + 1)).reshape(shape + 1)
    where = np.argwhere(grid.kind == SOLID)
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corner = np.concatenate([corner, corner + np.array([0, 0, 1])])
    at = where[:, None] + corner
    cells = number[at[..., 0], at[..., 1], at[..., 2]]
    used, inverse = np.unique(cells, return_inverse=True)
    points = np.stack(np.meshgrid(*grid.planes, indexing="ij"), axis=-1).reshape(-1, 3)[used]
    cells = inverse.reshape(cells.shape).astype(np.int64)
    regions = {
        name: np.flatnonzero(inside[tuple(where.T)]) for name, inside in grid.regions.items()
    }
    return SolidMesh(points, cells, _facets(grid, where, faces(cells), half), regions)


def _facets(grid: Grid, where: Ints, every: Ints, half: bool) -> dict[str, Ints]:
    """Boundary facets by group; ``every`` has six rows for each of the cells ``where``."""
    padded = np.pad(grid.kind, 1, constant_values=OUTSIDE)
    shape = np.array(grid.kind.shape)
    names = np.full((len(where), len(NEIGHBOUR)), "", dtype=object)
    in_cup = grid.planes[2][where[:, 2]] < grid.cup_mm - THINNEST_MM / 10
    for face, (axis, side) in enumerate(NEIGHBOUR):
        beyond = where.copy()
        beyond[:, axis] += 2 * side - 1
        kind = padded[tuple((beyond + 1).T)]
        names[kind == CAVITY, face] = groups.CAVITY
        names[kind == OUTSIDE, face] = groups.SKIN
        names[(kind == OUTSIDE) & in_cup, face] = groups.CLAMP
        end = (beyond[:, axis] < 0) | (beyond[:, axis] >= shape[axis])
        if axis == 2:
            names[end, face] = groups.TIP if side else groups.CLAMP
        elif axis == 1 and half and not side:
            names[end, face] = groups.SYMMETRY
    flat = names.ravel()
    return {name: every[flat == name] for name in groups.SURFACE_TAGS if (flat == name).any()}

"""Walls and gaps of a finger of boxes: pairs of faces that stand opposite each other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from dolfingrip.meshes.dimensions import own
from dolfingrip.meshes.solid import Floats
from dolfingrip.meshes.structured import CAVITY, OUTSIDE, SOLID, grid
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.specimen import Mesh

_ROUND = ((0, 0), (1, 0), (1, 1), (0, 1))
"""Corners of a face in order, as steps along its two axes."""


@dataclass(frozen=True, slots=True)
class Facing:
    """Pairs of faces of the mesh that stand opposite each other.

    Attributes:
        corners: shape (pairs, 2, 4, 3), corners (mm) of both faces in the straight mesh.
    """

    corners: Floats

    def distances(self, corners: Floats) -> Floats:
        """Distance (mm) at each of the four corners, across the mean of both faces' normals.

        Args:
            corners: (k, 2, 4, 3), the same corners where they have moved to.

        Returns:
            Shape (k, 4).
        """
        normal, length = _normals(corners)
        apart = corners[:, 1] - corners[:, 0]
        return np.asarray(np.einsum("kci,ki->kc", apart, normal / length[:, None]))

    def slopes(self, corners: Floats, velocity: Floats) -> Floats:
        """Derivatives of :meth:`distances` for some velocities.

        Args:
            corners: (k, 2, 4, 3).
            velocity: (p, k, 2, 4, 3), mm for each unit of p parameters.

        Returns:
            Shape (p, k, 4).
        """
        normal, length = _normals(corners)
        unit = normal / length[:, None]
        first, second = _diagonals(corners)
        moving = np.zeros((len(velocity), *normal.shape))
        for side in range(2):
            v = velocity[:, :, side]
            moving += np.cross(v[:, :, 2] - v[:, :, 0], second[:, side])
            moving += np.cross(first[:, side], v[:, :, 3] - v[:, :, 1])
        turning = (moving - unit * np.einsum("pki,ki->pk", moving, unit)[..., None]) / length[
            :, None
        ]
        apart = corners[:, 1] - corners[:, 0]
        return np.asarray(
            np.einsum("pkci,ki->pkc", velocity[:, :, 1] - velocity[:, :, 0], unit)
            + np.einsum("kci,pki->pkc", apart, turning)
        )


def _diagonals(corners: Floats) -> tuple[Floats, Floats]:
    return corners[:, :, 2] - corners[:, :, 0], corners[:, :, 3] - corners[:, :, 1]


def _normals(corners: Floats) -> tuple[Floats, Floats]:
    """Sum of both faces' normals (k, 3), from the first face to the second, and its length."""
    normal = np.cross(*_diagonals(corners)).sum(axis=1)
    return normal, np.linalg.norm(normal, axis=1)


def facing(dimensions: Geometry, mesh: Mesh) -> tuple[Facing, Facing, Facing]:
    """Walls of the cavity, gaps between neighbouring parts, and hollows, of a structured mesh.

    Args:
        dimensions: dimensions of the finger (mm).
        mesh: settings of its structured mesh.

    Returns:
        Walls, gaps and hollows.
    """
    cells = grid(dimensions.alike(), mesh)
    walls: list[Floats] = []
    gaps: list[Floats] = []
    hollows: list[Floats] = []
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        kind = np.moveaxis(cells.kind, axis, 0)
        ends = np.pad(kind, ((1, 1), (0, 0), (0, 0)), constant_values=-1)
        for place in product(*(range(count) for count in kind.shape[1:])):
            column = kind[:, place[0], place[1]]
            beside = ends[:, place[0], place[1]]
            for start, end in _runs(column):
                sides = {int(beside[start]), int(beside[end + 1])}
                inner = int(column[start])
                mirrored = axis == 1 and mesh.half and start == 0
                if inner == SOLID and CAVITY in sides and not mirrored:
                    walls.append(_faces(cells.planes, axis, others, place, start, end))
                elif inner == OUTSIDE and sides == {SOLID}:
                    gaps.append(_faces(cells.planes, axis, others, place, start, end))
                elif inner == CAVITY and sides == {SOLID}:
                    hollows.append(_faces(cells.planes, axis, others, place, start, end))
    facings = [_stacked(faces, dimensions) for faces in (walls, gaps, hollows)]
    return facings[0], facings[1], facings[2]


def _stacked(faces: list[Floats], dimensions: Geometry) -> Facing:
    corners = np.array(faces) if faces else np.empty((0, 2, 4, 3))
    if (place := own(dimensions)) is not None:
        corners = place(corners.reshape(-1, 3)).reshape(corners.shape)
    return Facing(corners)


def _runs(column: NDArray[np.int64]) -> list[tuple[int, int]]:
    """First cell and the cell after the last one of each run of one kind."""
    change = np.flatnonzero(np.diff(column)) + 1
    starts, ends = [0, *change], [*change, len(column)]
    return list(zip(map(int, starts), map(int, ends), strict=True))


def _faces(
    planes: tuple[Floats, ...],
    axis: int,
    others: list[int],
    place: tuple[int, ...],
    start: int,
    end: int,
) -> Floats:
    """Corners (2, 4, 3) of the faces at both ends of a run, each with its normal along the axis."""
    corners = np.empty((2, 4, 3))
    order = _ROUND if axis != 1 else _ROUND[::-1]  # x, z are left-handed about y
    for side, at in enumerate((start, end)):
        for corner, steps in enumerate(order):
            corners[side, corner, axis] = planes[axis][at]
            for other, cell, step in zip(others, place, steps, strict=True):
                corners[side, corner, other] = planes[other][cell + step]
    return corners

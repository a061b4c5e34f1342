"""Solids made of boxes or cylinders, from which meshes are made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TOLERANCE_MM: Final = 1e-5
"""Larger than the padding of OpenCASCADE's bounding boxes, smaller than any dimension."""

THINNEST_MM: Final = 0.01
"""Least distance of two parallel faces; the kernel may drop what is much thinner."""

Interval = tuple[float, float]
Box = tuple[Interval, Interval, Interval]
"""Extent (mm) along x, y and z."""

Marks = tuple[Sequence[float], Sequence[float], Sequence[float]]
"""Coordinates (mm) along x, y and z."""


@dataclass(frozen=True, slots=True)
class BoxSolid:
    """A block with hollows.

    Attributes:
        body: the block.
        cavity, gaps: hollows inside and spaces outside, which overlap as they like.
        rising, falling: planes with the hollow side of a concave edge above and below them, where
            the mesh is graded.
        walls: planes that thick walls begin at, graded on both sides where the mesh asks for that;
            None: ``rising`` and ``falling``.
        regions: boxes of other material by name, later ones over earlier ones; what is in none of
            them is named ``rest``.
        rest: name of the remaining region; "" where there are no regions.
        cup_mm: length along z over which the sides are also clamped.
    """

    body: Box
    cavity: Sequence[Box]
    gaps: Sequence[Box]
    rising: Marks
    falling: Marks
    regions: Mapping[str, Sequence[Box]] = field(default_factory=dict)
    rest: str = ""
    cup_mm: float = 0.0
    walls: Marks | None = None

    def graded(self, axis: int, *, both_sides: bool) -> tuple[Sequence[float], Sequence[float]]:
        """Planes across an axis above and below which the mesh is graded (mm)."""
        if not both_sides:
            return self.rising[axis], self.falling[axis]
        walls = self.walls
        every = [*self.rising[axis], *self.falling[axis]] if walls is None else walls[axis]
        return every, every

    def planes(self, axis: int) -> Floats:
        """Coordinates of all faces across an axis (mm), in an order that the dimensions set."""
        cup = [self.cup_mm] if axis == 2 and self.cup_mm else []
        return np.array([*(value for box in self._boxes() for value in box[axis]), *cup])

    def bent(self, axis: int) -> Floats:
        """Coordinates of the planes across an axis that a free form bends (mm), ascending.

        The contact face, the clamp, the tip's face and the symmetry plane stay; of two planes that
        mirror each other in y, it is the one above 0.
        """
        planes = np.sort(self.planes(axis))
        planes = planes[np.concatenate([[True], np.diff(planes) > TOLERANCE_MM])]
        low, high = self.body[axis]
        lowest = 0.0 if axis == 1 else low
        inside = planes > lowest + TOLERANCE_MM
        if axis == 2:
            inside &= planes < high - TOLERANCE_MM
        return planes[inside]

    def _boxes(self) -> Iterator[Box]:
        yield self.body
        yield from self.cavity
        yield from self.gaps
        for boxes in self.regions.values():
            yield from boxes


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z with its axis in the plane y = 0.

    Attributes:
        axis_mm: place x of the axis.
        radius_mm: radius.
        along_mm: extent along z.
    """

    axis_mm: float
    radius_mm: float
    along_mm: Interval


@dataclass(frozen=True, slots=True)
class CylinderSolid:
    """Blocks and cylinders, less the hollows inside.

    Attributes:
        blocks, cylinders: the solid, which overlap as they like.
        cavities: for each cavity its cylinders, which overlap as they like.
    """

    blocks: Sequence[Box]
    cylinders: Sequence[Cylinder]
    cavities: Sequence[Sequence[Cylinder]]

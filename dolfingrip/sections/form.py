"""Section of the configuration for free form: how the planes of a finger's faces are bent."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Final

import numpy as np
from pydantic import Field

from dolfingrip.sections.section import FINGERS, Entry, Role, Section

if TYPE_CHECKING:
    from dolfingrip.sections.geometry.boxes import BoxSolid

ACROSS: Final = 2
"""Numbers of a field across the finger, along x or y."""


DEGREE: Final = 2
"""Of the splines along z."""


@dataclass(frozen=True, slots=True)
class Offset:
    """The place of a plane that one offset moves.

    Attributes:
        axis: that its plane is across.
        plane_mm: the plane's coordinate along that axis.
        function: number of its function across the finger.
        along: where on z its spline stands, 0 to 1 (Greville's abscissa); across z, its number.
    """

    axis: int
    plane_mm: float
    function: int
    along: float


class Form(Section):
    """Free form: every plane of the finger's faces is bent by a spline over it.

    The planes z = 0 (clamp), the tip's face and the symmetry plane stay, and x = 0 (contact face)
    unless it is asked for.
    """

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    entry: ClassVar = Entry.SHAPE
    later: ClassVar = {"contact_face": False}

    contact_face: bool = Field(
        False, description="whether x = 0, which touches food and plate, is bent, too"
    )
    along: int = Field(5, ge=3, le=40, description="numbers of a field along z")
    offsets_mm: Annotated[
        tuple[Annotated[float, Field(ge=-50, le=50)], ...],
        Field(
            strict=False,
            description="of the planes across x, then y, then z, each from the lowest; of each "
            "plane 2 by along numbers, across z 2 by 2",
        ),
    ]

    def count(self, solid: BoxSolid) -> int:
        """Number of offsets that a solid's planes take."""
        return sum(len(self.planes(solid, axis)) * self.of_plane(axis) for axis in range(3))

    def planes(self, solid: BoxSolid, axis: int) -> np.ndarray:
        """Coordinates of a solid's planes across an axis that are bent (mm), ascending."""
        face = [solid.body[0][0]] if axis == 0 and self.contact_face else []
        return np.array([*face, *solid.bent(axis)])

    def of_plane(self, axis: int) -> int:
        """Number of offsets of one plane across an axis."""
        return ACROSS * (ACROSS if axis == 2 else self.along)

    def each(self, solid: BoxSolid) -> Iterator[Offset]:
        """Yield the places that the offsets of a solid's planes move, in order."""
        for axis in range(3):
            for plane in self.planes(solid, axis):
                for function in range(ACROSS):
                    count = ACROSS if axis == 2 else self.along
                    for i in range(count):
                        along = float(i) if axis == 2 else self._abscissa(i)
                        yield Offset(axis, float(plane), function, along)

    def _abscissa(self, i: int) -> float:
        """Mean of the knots inside the support of a spline, as a part of the finger's length."""
        pieces = self.along - DEGREE
        inside = [min(max(i + k - DEGREE, 0), pieces) for k in range(1, DEGREE + 1)]
        return sum(inside) / DEGREE / pieces

"""Section of the configuration for free form: how the planes of a finger's faces are bent."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

from pydantic import Field

from dolfingrip.sections.section import Section

if TYPE_CHECKING:
    from dolfingrip.sections.geometry.boxes import BoxSolid

ACROSS: Final = 2
"""Numbers of a field across the finger, along x or y."""


class Form(Section):
    """Free form: every plane of the finger's faces is bent by a spline over it.

    The planes x = 0 (contact face), z = 0 (clamp), the tip's face and the symmetry plane stay.
    """

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
        return sum(len(solid.bent(axis)) * self.of_plane(axis) for axis in range(3))

    def of_plane(self, axis: int) -> int:
        """Number of offsets of one plane across an axis."""
        return ACROSS * (ACROSS if axis == 2 else self.along)

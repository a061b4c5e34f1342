"""The base class of shapes of food: keys, portions, signed distance and skin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from pydantic import Field

from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.sections.section import Role, Section


class Portion(NamedTuple):
    """Size and density where none are given.

    Attributes:
        width_mm: along x.
        length_mm: along y.
        height_mm: along z.
        density_kg_m3: of its flesh.
    """

    width_mm: float
    length_mm: float
    height_mm: float
    density_kg_m3: float


class FoodKind(Section):
    """The keys that a shape has in ``[food]``, each with a default.

    Attributes:
        portions: by ``food.kind``.
        lying: rotation vector (rad) from how it is drawn to how it lies; None: to where its hull
            lies still.
        exclusive: keys that are refused with another kind.
        colour: in pictures.
    """

    role: ClassVar = Role.SETUP
    portions: ClassVar[Mapping[str, Portion]]
    lying: ClassVar[tuple[float, float, float] | None] = None
    exclusive: ClassVar[tuple[str, ...]] = ()
    colour: ClassVar[str] = "#E0B060"

    def check(self, size_mm: tuple[float, float, float]) -> None:
        """Raise :func:`~dolfingrip.sections.section.outside` where there is no such food.

        Args:
            size_mm: outer width, length and height.
        """

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        """Distance and skin as drawn, the centre of gravity at the origin.

        Raises:
            MeshError: one line, where it cannot be.
        """
        raise NotImplementedError


class SampledKind(FoodKind):
    """Food with no distance in closed form."""

    grid_mm: float = Field(
        2.5,
        gt=0.1,
        le=20,
        description="potato, strawberry, file: spacing of the distance's samples",
    )

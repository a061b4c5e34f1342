"""The base class of kinds of geometry: outer size, walls, regions and solid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import Field

from dolfingrip.sections.geometry.boxes import THINNEST_MM, BoxSolid, CylinderSolid, Interval
from dolfingrip.sections.section import FINGERS, Entry, Role, Section

Length = Annotated[float, Field(ge=THINNEST_MM, le=500)]
"""Type of a dimension (mm)."""

# an alias with a name of its own: jedi cannot complete objects with a property of a bare Literal
type Integration = Literal["reduced", "full", "selective"]


@dataclass(frozen=True, slots=True)
class Gaps:
    """Gaps along a finger.

    Attributes:
        intervals: extent along z (mm) of each gap, from clamp to tip.
        parts: names of the parts between the gaps, one more than there are gaps.
        floor_mm: height x of the gaps' floors, of the highest one.
        width_mm: clear distance across a gap, across the widest one.
    """

    intervals: list[Interval] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)
    floor_mm: float = 0.0
    width_mm: float = 0.0


class Geometry(Section):
    """A table of dimensions, and the solid with these dimensions.

    The strain-limiting side is the plane x = 0, the contact face, which the plate and food meet.
    The clamp is the plane z = 0, the tip lies at z = length_mm, the symmetry plane is y = 0.

    Attributes:
        regions: names of the solid's regions; none where it is one.
        limiting: region that limits strain by a material or a film of its own; "" where the shape
            alone does.
        integration: of hexahedra, where the configuration names none.
        tetrahedra: whether it can be meshed in tetrahedra, which know no regions.
        hexahedra: whether it can be meshed in hexahedra, as boxes can.
        of_file: whether its solid is a mesh file, which it must then have.
        cast: whether it is cast in a mould, a body and a base that close its hollows.
        thin: whether one element across a wall bears the pressure, so that no mesh is too coarse.
        number: key of the number of its chambers.
        own: keys of dimensions that a chamber may have of its own.
        length_mm: clamp to tip, along z.
        width_mm: outer width along y.
        depth_mm: contact face to crown, along x.
        wall_mm: thickness of the walls around the chambers.
        pitch_mm: distance from one chamber to the next, of kinds that have one.
    """

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    entry: ClassVar = Entry.SHAPE
    regions: ClassVar[tuple[str, ...]] = ()
    limiting: ClassVar[str] = ""
    integration: ClassVar[Integration] = "selective"
    tetrahedra: ClassVar[bool] = False
    hexahedra: ClassVar[bool] = True
    of_file: ClassVar[bool] = False
    cast: ClassVar[bool] = False
    thin: ClassVar[bool] = False
    number: ClassVar[str] = "chambers"
    own: ClassVar[tuple[str, ...]] = ()

    if TYPE_CHECKING:  # each is a key of the table or a property

        @property
        def length_mm(self) -> float: ...

        @property
        def width_mm(self) -> float: ...

        @property
        def depth_mm(self) -> float: ...

        @property
        def wall_mm(self) -> float: ...

        @property
        def pitch_mm(self) -> float: ...

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        return self.wall_mm

    @classmethod
    def table(cls) -> str:
        """Name of its table in the configuration, as of its file."""
        return cls.__module__.rpartition(".")[2]

    def solid(self) -> BoxSolid | CylinderSolid:
        """The solid of these dimensions."""
        raise NotImplementedError

    @property
    def sealed(self) -> Mapping[str, Any]:
        """Changes of keys that leave no tube through the clamped face."""
        none = {"tube": False, "tube_mm": 0.0}
        return {key: value for key, value in none.items() if hasattr(self, key)}

    def boxes(self) -> BoxSolid | None:
        """The solid with the shared dimensions, if it is made of boxes; None otherwise.

        A free form bends its planes.
        """
        solid = self.alike().solid()
        return solid if isinstance(solid, BoxSolid) else None

    def cavities(self) -> tuple[str, ...]:
        """Surface groups of its cavities."""
        return ("cavity",)

    def count(self) -> tuple[str, int]:
        """Return key and value of the number that no mesh can be moved to another of."""
        return f"{self.table()}.{self.number}", int(getattr(self, self.number))

    differ: ClassVar[bool] = False  # or a property, where chambers may

    def of(self, chamber: int) -> Self:
        """Dimensions of a finger all of whose chambers are like one of this finger's.

        Args:
            chamber: from the clamp, from 0 on.
        """
        return self

    def alike(self) -> Self:
        """Dimensions of a finger all of whose chambers have the shared ones."""
        return self

    def longer_mm(self) -> list[float]:
        """By how much the pitches before each chamber, and of all, exceed the shared one."""
        excess_mm = (self.of(i).pitch_mm - self.pitch_mm for i in range(self.count()[1]))
        return list(accumulate(excess_mm, initial=0.0))

    def insides(self, outer: Sequence[Interval]) -> list[Interval]:
        """Extents along z (mm) of chambers within their own walls.

        Args:
            outer: extents of the chambers with their walls.
        """
        walls = [self.of(i).wall_mm for i in range(len(outer))]
        return [(start + wall, end - wall) for (start, end), wall in zip(outer, walls, strict=True)]

    def sections(self) -> list[tuple[Interval, Self]]:
        """Stretches along z (mm) with one cross-section each, from the clamp, and its dimensions.

        Between two stretches the cross-section changes linearly.
        """
        return [((0.0, self.length_mm), self)]

    def offset(self, key: str, by_mm: float) -> dict[str, Any]:
        """Return the changes of keys that make a dimension of all chambers larger.

        Args:
            key: of the dimension.
            by_mm: added to it.
        """
        return {key: getattr(self, key) + by_mm}

    def gaps(self) -> Gaps:
        """The clear spaces between neighbouring parts; none of a solid block."""
        return Gaps()

    def distances_mm(self) -> Mapping[str, float]:
        """Least distance of parallel faces by the key that sets it; empty: as the boxes tell."""
        return {}

    def thickness_mm(self, region: str) -> float | None:
        """Thickness of a region that is a layer, its key REGION_mm; None of another."""
        thickness = getattr(self, f"{region}_mm", None)
        return None if thickness is None else float(thickness)

"""Two round bellows side by side between two blocks: the pressure in one of them bends them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from pydantic import Field

from dolfingrip.sections.geometry.boxes import Cylinder, CylinderSolid, Interval
from dolfingrip.sections.geometry.geometry import Geometry, Length
from dolfingrip.sections.section import Refusal


class RoundBellows(Geometry):
    """Two bellows of round convolutions along z, one at the contact face x = 0, one behind it.

    The one behind has the cavity ``cavity``, the one at the contact face ``cavity_2``. With
    ``cavity.cavity_2.pressure_ratio = 0`` that one is vented, and the actuator bends towards −x, as
    the bellows finger does.
    """

    tetrahedra: ClassVar = True
    hexahedra: ClassVar = False
    number: ClassVar = "convolutions"
    own: ClassVar = ("crown_radius_mm", "pitch_mm", "gap_mm", "wall_mm")

    convolutions: int = Field(8, ge=1, le=60, description="of each bellows")
    crown_radius_mm: Length = Field(12.5, description="outside")
    neck_radius_mm: Length = Field(3.0, description="outside")
    pitch_mm: Length = Field(7.0, description="of the convolutions, along z")
    gap_mm: Length = Field(2.5, description="between convolutions, along z")
    wall_mm: Length = Field(0.8, description="all walls of the bellows")
    apart_mm: Length = Field(2.0, description="clear distance of the two bellows' crowns")
    block_mm: Length = Field(5.0, description="blocks at clamp and tip, along z")
    tube_mm: float = Field(
        0.0, ge=0, le=500, description="tube from each cavity through the clamped face; 0: none"
    )

    @property
    def length_mm(self) -> float:
        """Clamp to tip, along z."""
        return 2 * self.block_mm + self.convolutions * self.pitch_mm + self.longer_mm()[-1]

    @property
    def width_mm(self) -> float:
        """Crown to crown, along y."""
        return 2 * self.crown_radius_mm

    @property
    def depth_mm(self) -> float:
        """Crown of the first bellows to crown of the second one, along x."""
        return 4 * self.crown_radius_mm + self.apart_mm

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        return min(self.wall_mm, self.gap_mm)

    def movable(self, key: str) -> bool:
        """No mesh of round faces moves by planes."""
        return False

    def cavities(self) -> tuple[str, ...]:
        """Surface groups of the cavities."""
        return ("cavity", "cavity_2")

    def crowns(self) -> list[Interval]:
        """Outer extent along z (mm) of each convolution."""
        intervals = []
        for i, longer in enumerate(self.longer_mm()[:-1]):
            convolution = self.of(i)
            start = self.block_mm + i * self.pitch_mm + longer + convolution.gap_mm / 2
            intervals.append((start, start + convolution.pitch_mm - convolution.gap_mm))
        return intervals

    def solid(self) -> CylinderSolid:
        """The blocks, and convolutions on a tube along each axis."""
        wall, ends = self.wall_mm, (self.block_mm, self.length_mm - self.block_mm)
        outer: list[Cylinder] = []
        inner: list[list[Cylinder]] = []
        first = self.crown_radius_mm
        for axis in (first, self.depth_mm - first):
            outer.append(Cylinder(axis, self.neck_radius_mm, ends))
            hollow = []
            for i, (start, end) in enumerate(self.crowns()):
                radius, shell = self.of(i).crown_radius_mm, self.of(i).wall_mm
                outer.append(Cylinder(axis, radius, (start, end)))
                hollow.append(Cylinder(axis, radius - shell, (start + shell, end - shell)))
            tube = Cylinder(axis, self.tube_mm / 2, (0.0, self.block_mm))
            neck = Cylinder(axis, self.neck_radius_mm - wall, ends)
            inner.append([neck, *hollow, *([tube] if self.tube_mm else ())])
        across = (-self.width_mm / 2, self.width_mm / 2)
        depth = (0.0, self.depth_mm)
        blocks = [
            (depth, across, (0.0, self.block_mm)),
            (depth, across, (self.length_mm - self.block_mm, self.length_mm)),
        ]
        return CylinderSolid(blocks, outer, inner)

    def distances_mm(self) -> Mapping[str, float]:
        """Least distance of parallel faces by the key that sets it."""
        return {
            **({"tube_mm": self.tube_mm} if self.tube_mm else {}),
            "gap_mm": self.gap_mm,
            "pitch_mm": self.pitch_mm - self.gap_mm - 2 * self.wall_mm,
            "neck_radius_mm": self.neck_radius_mm - self.wall_mm,
            "crown_radius_mm": self.crown_radius_mm - self.neck_radius_mm,
            "wall_mm": self.wall_mm,
        }

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        least_mm = self.gap_mm + 2 * self.wall_mm
        yield from self.above("pitch_mm", least_mm, "leaves no cavity in a convolution; ")
        yield from self.above("neck_radius_mm", "wall_mm", "closes the necks; ")
        yield from self.above("crown_radius_mm", "neck_radius_mm")
        if self.tube_mm:
            yield from self.up_to("tube_mm", 2 * (self.neck_radius_mm - self.wall_mm), "too wide; ")

"""Two round bellows side by side between two blocks: the pressure in one of them bends them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field, model_validator

from dolfingrip.sections.geometry.boxes import THINNEST_MM, Interval
from dolfingrip.sections.geometry.cylinders import Cylinder, CylinderSolid
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.section import outside


class RoundBellows(Geometry):
    """Two bellows of round convolutions along z, one at the contact face x = 0, one behind it.

    The one behind has the cavity ``cavity``, the one at the contact face ``cavity_2``. With
    ``cavity.cavity_2.pressure_ratio = 0`` that one is vented, and the actuator bends towards −x, as
    the bellows finger does.
    """

    tetrahedra: ClassVar = True
    hexahedra: ClassVar = False

    convolutions: int = Field(8, ge=1, le=60, description="of each bellows")
    crown_radius_mm: float = Field(12.5, ge=THINNEST_MM, le=500, description="outside")
    neck_radius_mm: float = Field(3.0, ge=THINNEST_MM, le=500, description="outside")
    pitch_mm: float = Field(7.0, ge=THINNEST_MM, le=500, description="of the convolutions, along z")
    gap_mm: float = Field(2.5, ge=THINNEST_MM, le=500, description="between convolutions, along z")
    wall_mm: float = Field(0.8, ge=THINNEST_MM, le=500, description="all walls of the bellows")
    apart_mm: float = Field(
        2.0, ge=THINNEST_MM, le=500, description="clear distance of the two bellows' crowns"
    )
    block_mm: float = Field(
        5.0, ge=THINNEST_MM, le=500, description="blocks at clamp and tip, along z"
    )

    @property
    def length_mm(self) -> float:
        """Clamp to tip, along z."""
        return 2 * self.block_mm + self.convolutions * self.pitch_mm

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

    def count(self) -> tuple[str, int]:
        """Key and value of the number that no mesh can be moved to another of."""
        return "round_bellows.convolutions", self.convolutions

    def movable(self, key: str) -> bool:
        """No mesh of round faces moves by planes."""
        return False

    def cavities(self) -> tuple[str, ...]:
        """Surface groups of the cavities."""
        return ("cavity", "cavity_2")

    def crowns(self) -> list[Interval]:
        """Outer extent along z (mm) of each convolution."""
        starts = [
            self.block_mm + i * self.pitch_mm + self.gap_mm / 2 for i in range(self.convolutions)
        ]
        return [(start, start + self.pitch_mm - self.gap_mm) for start in starts]

    def solid(self) -> CylinderSolid:
        """The blocks, and convolutions on a tube along each axis."""
        wall, ends = self.wall_mm, (self.block_mm, self.length_mm - self.block_mm)
        outer: list[Cylinder] = []
        inner: list[list[Cylinder]] = []
        first = self.crown_radius_mm
        for axis in (first, self.depth_mm - first):
            outer.append(Cylinder(axis, self.neck_radius_mm, ends))
            outer += [Cylinder(axis, self.crown_radius_mm, z) for z in self.crowns()]
            hollow = [
                Cylinder(axis, self.crown_radius_mm - wall, (start + wall, end - wall))
                for start, end in self.crowns()
            ]
            inner.append([Cylinder(axis, self.neck_radius_mm - wall, ends), *hollow])
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
            "gap_mm": self.gap_mm,
            "pitch_mm": self.pitch_mm - self.gap_mm - 2 * self.wall_mm,
            "neck_radius_mm": self.neck_radius_mm - self.wall_mm,
            "crown_radius_mm": self.crown_radius_mm - self.neck_radius_mm,
            "wall_mm": self.wall_mm,
        }

    @model_validator(mode="after")
    def _possible(self) -> RoundBellows:
        least = self.gap_mm + 2 * self.wall_mm
        if self.pitch_mm <= least:
            raise outside(
                "pitch_mm",
                self.pitch_mm,
                f"leaves no cavity in a convolution; allowed: above {least:g} mm",
            )
        if self.neck_radius_mm <= self.wall_mm:
            raise outside(
                "neck_radius_mm",
                self.neck_radius_mm,
                f"closes the necks; allowed: above wall_mm = {self.wall_mm:g} mm",
            )
        if self.crown_radius_mm <= self.neck_radius_mm:
            raise outside(
                "crown_radius_mm",
                self.crown_radius_mm,
                f"allowed: above neck_radius_mm = {self.neck_radius_mm:g} mm",
            )
        return self

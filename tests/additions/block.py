"""A made-up kind of geometry: a block with one chamber."""

from __future__ import annotations

from pydantic import Field

from dolfingrip.sections.geometry.boxes import BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry


class Block(Geometry):
    """Block: its thin side at x = 0, clamped at z = 0."""

    length_mm: float = Field(24.0, gt=0, le=500, description="clamp to tip, along z")
    width_mm: float = Field(12.0, gt=0, le=500, description="along y")
    depth_mm: float = Field(12.0, gt=0, le=500, description="along x")
    floor_mm: float = Field(2.0, gt=0, le=500, description="below the chamber")
    wall_mm: float = Field(4.0, gt=0, le=500, description="all other walls")

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        return self.floor_mm

    def count(self) -> tuple[str, int]:
        """It has one chamber."""
        return "block.chambers", 1

    def solid(self) -> BoxSolid:
        """The block and its chamber."""
        inner = self.width_mm / 2 - self.wall_mm
        x = (self.floor_mm, self.depth_mm - self.wall_mm)
        z = (self.wall_mm, self.length_mm - self.wall_mm)
        return BoxSolid(
            (
                (0.0, self.depth_mm),
                (-self.width_mm / 2, self.width_mm / 2),
                (0.0, self.length_mm),
            ),
            [(x, (-inner, inner), z)],
            [],
            rising=([x[0]], [-inner], [z[0]]),
            falling=([x[1]], [inner], [z[1]]),
        )

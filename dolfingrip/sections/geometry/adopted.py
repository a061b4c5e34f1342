"""A part of the user's own: a mesh file, and the outer size of its solid."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.sections.geometry.geometry import Geometry


class AdoptedGeometry(Geometry):
    """A part that `dolfingrip adopt` has turned into a mesh file; its outer size and its walls."""

    of_file: ClassVar = True
    hexahedra: ClassVar = False
    effort: ClassVar = ("chamber_mm", "back", "bends_to_back", "doubts")  # what adopt told of it
    later: ClassVar = {"solid_body": False}

    length_mm: float = Field(100.0, gt=0, le=10_000, description="clamp to tip, along z")
    width_mm: float = Field(20.0, gt=0, le=10_000, description="along y")
    depth_mm: float = Field(20.0, gt=0, le=10_000, description="back to front, along x")
    wall_mm: float = Field(2.0, gt=0, le=10_000, description="thinnest wall")
    chamber_mm: float = Field(
        0.0, ge=0, le=10_000, description="width of the widest chamber, 0: not known"
    )
    solid_body: bool = Field(False, description="a body without a cavity")
    back: str = Field("", description="what told which side limits strain, for the report")
    bends_to_back: bool = Field(False, description="by one step of pressure as it was adopted")
    doubts: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="about the mesh as it was adopted"
    )

    def cavities(self) -> tuple[str, ...]:
        """None of a solid body."""
        return () if self.solid_body else super().cavities()

    def movable(self, key: str) -> bool:
        """No dimension moves the file's mesh."""
        return False

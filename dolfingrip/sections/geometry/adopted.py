"""A part of the user's own: a mesh file, and the outer size of its solid."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from dolfingrip.sections.geometry.geometry import Geometry


class AdoptedGeometry(Geometry):
    """A part that `dolfingrip adopt` has turned into a mesh file; its outer size and its walls."""

    of_file: ClassVar = True

    length_mm: float = Field(100.0, gt=0, le=10_000, description="clamp to tip, along z")
    width_mm: float = Field(20.0, gt=0, le=10_000, description="along y")
    depth_mm: float = Field(20.0, gt=0, le=10_000, description="back to front, along x")
    wall_mm: float = Field(2.0, gt=0, le=10_000, description="thinnest wall")

    def movable(self, key: str) -> bool:
        """No dimension moves the file's mesh."""
        return False

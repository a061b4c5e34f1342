"""Food of any shape, from an STL file."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from pydantic import Field

from dolfingrip.foods.kind import Portion, SampledKind
from dolfingrip.foods.skin import sampled
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes import closed_surface
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.sections.section import outside


class Stl(SampledKind):
    """A closed surface, which has its own size."""

    portions: ClassVar = {"file": Portion(0.0, 0.0, 0.0, 1000.0)}
    exclusive: ClassVar = ("file",)

    file: Path | None = Field(
        None, strict=False, description="closed STL surface in mm, z upwards; with kind = file"
    )
    smoothing_mm: float = Field(
        1.0, ge=0, le=20, description="file: standard deviation that rounds its edges off"
    )

    def check(self, size_mm: tuple[float, float, float]) -> None:
        if self.file is None:
            raise outside("file", "none", "allowed: a path")
        if any(size_mm):
            raise outside("kind", "file", "has its own size; allowed: no width, length or height")

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        assert self.file is not None  # the validator sees to it
        return sampled(closed_surface.read(self.file), self.grid_mm, self.smoothing_mm)

"""A cube, with rounded edges."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.foods.kind import FoodKind, Portion
from dolfingrip.foods.skin import skin_of
from dolfingrip.mechanics.contact.distance import RoundedBox, SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.sections.section import outside


class Cube(FoodKind):
    """The paper's cube, cut from a potato (section III.B)."""

    portions: ClassVar = {"cube": Portion(33.0, 33.0, 32.0, 1080.0)}
    lying: ClassVar = (0.0, 0.0, 0.0)

    edge_radius_mm: float = Field(1.0, gt=0, le=100, description="cube: of its rounded edges")

    def check(self, size_mm: tuple[float, float, float]) -> None:
        limit = min(size_mm) / 2
        if self.edge_radius_mm > limit:
            raise outside(
                "edge_radius_mm", self.edge_radius_mm, f"allowed: above 0 and up to {limit:g} mm"
            )

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        half = np.array(size_mm) / 2
        box = RoundedBox((half[0], half[1], half[2]), self.edge_radius_mm)
        return box, skin_of(box, half)

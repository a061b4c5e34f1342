"""A sausage: a capsule, straight or bent."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.foods.kind import FoodKind, Portion
from dolfingrip.foods.skin import skin_of
from dolfingrip.mechanics.contact.distance import BentCapsule, Capsule, SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.sections.section import outside


class Sausage(FoodKind):
    """A sausage, round and along y.

    USDA's FoodData Central (SR Legacy) lists as the short one a canned Vienna sausage (7/8 in wide,
    2 in long, 16 g), as the long one a frankfurter (7/8 in, 5 in, eight to the pound at most). An
    emulsion of meat has a density of 1020 to 1070 kg/m³.
    """

    portions: ClassVar = {
        "sausage-short": Portion(22.2, 50.8, 22.2, 1040.0),
        "sausage-long": Portion(22.2, 127.0, 22.2, 1040.0),
    }
    # a capsule's own axis is z
    lying: ClassVar = (-math.pi / 2, 0.0, 0.0)

    bend_radius_mm: float | None = Field(
        None, gt=0, le=10_000, description="sausage: of its axis; default: straight"
    )

    def check(self, size_mm: tuple[float, float, float]) -> None:
        width, length, height = size_mm
        if height != width:
            raise outside("height_mm", height, f"allowed: width_mm = {width:g} mm, it is round")
        if length <= width:
            raise outside("length_mm", length, f"allowed: above width_mm = {width:g} mm")
        # bent further, its ends would meet or its inner side would fold
        least = max(width, (length - width) / 3)
        if self.bend_radius_mm is not None and self.bend_radius_mm < least:
            raise outside(
                "bend_radius_mm", self.bend_radius_mm, f"allowed: at least {least:.4g} mm"
            )

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        width, length, _ = size_mm
        radius, straight = width / 2, (length - width) / 2
        half = np.array([radius, radius, length / 2])
        if self.bend_radius_mm is None:
            capsule = Capsule(radius, straight)
            return capsule, skin_of(capsule, half)
        bent = BentCapsule(radius, straight, self.bend_radius_mm)
        half[0] += self.bend_radius_mm * (1 - math.cos(straight / self.bend_radius_mm))
        place = -float(skin_of(bent, half).centre_mm[0])
        bent = BentCapsule(radius, straight, self.bend_radius_mm, place)
        return bent, skin_of(bent, half)

"""Walls printed thicker or thinner than drawn."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import LabNumber, Prior
from dolfingrip.extensions.kinds import DimensionOffset


class WallOffset(DimensionOffset):
    """Walls thicker or thinner than drawn.

    wall = ``finger.wall_mm`` + offset. The wall grows inwards and the outside stays as it is. The
    finger is meshed anew.

    Prior: 0 ± 0.15 mm: printed walls of 1.6 mm are off by 5 to 15 %.
    Fingerprint: for 0.1 mm (6 %) more the angle falls by one factor at all pressures, 10 %. The
    force falls by 3 %, and by 7 % where bellows touch. Loading and unloading agree.
    Confused with: the modulus and the pressure's gain. They scale angle and force, too, but in
    another ratio.
    """

    told: ClassVar = LabNumber("wall", 0.05, "relative, of the walls' thickness wall_mm")
    dimension: ClassVar = "wall_mm"

    offset_mm: Annotated[float, Prior(0.0, 0.15, "walls ±5 to 15 % as printed")] = Field(
        0.1, ge=-10, le=10, description="added to finger.wall_mm"
    )

"""Walls printed thicker or thinner than drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior

if TYPE_CHECKING:
    from dolfingrip.sections.setup import Setup


class WallOffset(Effect):
    """Walls thicker or thinner than drawn.

    wall = ``finger.wall_mm`` + offset, inwards: the outside stays as it is. Meshed anew.

    Prior: 0 ± 0.15 mm, the 5 to 15 % that printed walls are off (of 1.6 mm).
    Fingerprint: for 0.1 mm (6 %) more the angle falls by one factor at all pressures, 10 %, the
    force by 3 % and, where bellows touch, 7 %. Loading and unloading agree.
    Confused with: the modulus and the pressure's gain, which scale angle and force otherwise
    relative to one another.
    """

    kind: ClassVar = "geometry"
    neutral: ClassVar = {"offset_mm": 0.0}

    offset_mm: Annotated[float, Prior(0.0, 0.15, "walls ±5 to 15 % as printed")] = Field(
        0.1, ge=-10, le=10, description="added to finger.wall_mm"
    )

    def adapt[S: Setup](self, config: S) -> S:
        return self.redrawn(config, "offset_mm", "wall_mm")

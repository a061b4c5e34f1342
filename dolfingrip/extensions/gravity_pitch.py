"""The finger's own weight, and the direction in which it hangs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Effect, Prior, Setup
from dolfingrip.sections.section import FINGERS


class GravityPitch(Effect):
    """Dead weight, with the direction of gravity in the plane of bending.

    b = ρ g (sin φ, 0, cos φ) per reference volume: φ = 0 hangs the finger tip down, φ = 90° pulls
    it towards the bellows, −90° towards the base layer. It sets the table ``gravity``, which may
    be given itself for any direction.

    Prior: 9.81 m/s², mounted within 3° of the intended direction (engineering guess).
    Fingerprint: sag that the first reading hides, because angles count from the unpressurised
    shape; the angle's slope differs as the finger turns into or out of gravity: hanging, 3.3 % less
    at 25 kPa and 1.7 % at 250 kPa. The plate is put to the hanging finger, too: its force changes
    by 0.002 N. Small for one finger: its weight is about 0.2 N.
    Confused with: permanent set, the angle's offset, a plate's gap.
    """

    kind: ClassVar = "set-up"
    felt_by: ClassVar = FINGERS
    shapeless: ClassVar = ("pitch_deg",)
    checks: ClassVar = (
        DirectCheck(
            "a spirit level at the clamp, and how the finger hung told under [gravity]", 2.0,
            {"pitch_deg": 0.5, "acceleration_m_s2": 0.1},
        ),
    )  # fmt: skip

    acceleration_m_s2: Annotated[float, Prior(9.81, 0.01, "standard gravity")] = Field(
        9.81, ge=0, le=1000, description="of free fall"
    )
    pitch_deg: Annotated[float, Prior(0.0, 3.0, "engineering guess")] = Field(
        0.0, ge=-180, le=180, description="from clamp-to-tip towards the bellows"
    )

    @classmethod
    def possible(cls, config: Setup) -> bool:
        """A finger with weight is pitched from where it hangs, tip down."""
        weight = config.gravity
        return not weight.acceleration_m_s2 or weight.direction == (0.0, 0.0, 1.0)

    @classmethod
    def given(cls, config: Setup) -> Mapping[str, float]:
        """The weight that is there already, whose direction alone may be off."""
        weight = config.gravity.acceleration_m_s2
        return {"acceleration_m_s2": weight} if weight else {}

    def adapt[S: Setup](self, config: S) -> S:
        angle = math.radians(self.pitch_deg)
        direction = [math.sin(angle), 0.0, math.cos(angle)]
        return config.changed(
            gravity={"acceleration_m_s2": self.acceleration_m_s2, "direction": direction}
        )

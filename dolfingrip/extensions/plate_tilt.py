"""A force sensor that is not mounted square."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Effect, Prior, Setup


class PlateTilt(Effect):
    """A force sensor tilted about y.

    tilt = ``plate.tilt_deg`` + offset; the force is the one normal to the tilted plate.

    Prior: 0 ± 2° (engineering guess).
    Fingerprint: the force by a small factor that grows with pressure, as the tip slides along the
    plate: 0.3 to 0.7 % for 2°. Free bending is untouched.
    Confused with: the force's gain, friction on the plate.
    """

    kind: ClassVar = "set-up"
    # the gap is that of the plate's nearest place, so the sign of a tilt tells which end of the
    # tip touches; with ±2° alone, a hidden tilt of −3.7° had a log evidence of 3, and friction one
    # of 35; with ±4°, too, the tilt has 44
    lopsided: ClassVar = True
    felt_by: ClassVar = ("plate",)
    checks: ClassVar = (DirectCheck("a square between plate and clamp", 5.0, {"offset_deg": 0.3}),)

    offset_deg: Annotated[float, Prior(0.0, 2.0, "engineering guess")] = Field(
        2.0, ge=-160, le=160, description="added to plate.tilt_deg"
    )

    def adapt[S: Setup](self, config: S) -> S:
        return config.changed(plate={"tilt_deg": config.plate.tilt_deg + self.offset_deg})

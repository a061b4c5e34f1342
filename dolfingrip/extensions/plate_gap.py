"""A force sensor mounted farther away than intended."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Effect, FittedKey, LabNumber, Prior, Setup


class PlateGapOffset(Effect):
    """A force sensor farther from the finger than intended.

    gap = ``plate.gap_mm`` + offset; it cannot be below 0, since an unpressurised finger that is
    pressed already is another experiment.

    Prior: 0.3 ± 0.3 mm (engineering guess).
    Fingerprint: no force up to the pressure at which the tip arrives, then a curve that is lower by
    nearly the same amount at all pressures, 0.007 to 0.009 N for 0.3 mm. Free bending is untouched.
    Confused with: the force's offset (there at no pressure, too), permanent set, a compliant clamp
    or sensor.
    """

    kind: ClassVar = "set-up"
    felt_by: ClassVar = ("plate",)
    told: ClassVar = LabNumber(
        "plate_gap_mm", 0.3, "of the force sensor's place, each time it is set", each_time=True
    )
    checks: ClassVar = (
        DirectCheck("a gauge block between finger and plate", 5.0, {"offset_mm": 0.05}),
    )

    offset_mm: Annotated[float, Prior(0.3, 0.3, "engineering guess", positive=True)] = Field(
        0.3, ge=-1000, le=1000, description="added to plate.gap_mm"
    )

    @classmethod
    def fitted(cls, config: Setup) -> FittedKey:
        return FittedKey("plate.gap_mm", config.plate.gap_mm, 0.0)

    def adapt[S: Setup](self, config: S) -> S:
        return config.changed(plate={"gap_mm": config.plate.gap_mm + self.offset_mm})

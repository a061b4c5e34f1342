"""A tube that holds more or less air than configured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, FittedKey, LabNumber, Prior, Setup
from dolfingrip.extensions.kinds import AirLineChange
from dolfingrip.sections.supply import AirLine


class DeadVolume(AirLineChange):
    """A tube that holds more or less air than configured.

    V_tube + this offset, of all that is between valve and cavity.

    Prior: 0 ± 1 cm³, half a metre of tube of 1.6 mm (engineering guess).
    Fingerprint: filling and venting take longer by the same part, at all pressures; waits
    untouched.
    Confused with: a valve that starves, which does the same to the filling; a softer body, whose
    cavity grows.
    """

    either: ClassVar = "more or less"
    told: ClassVar = LabNumber("dead_volume_cm3", 1.0, "between valve and cavity")
    checks: ClassVar = (
        DirectCheck("fill valve and tube with water and weigh it", 10.0, {"offset_cm3": 0.1}),
    )

    offset_cm3: Annotated[float, Prior(0.0, 1.0, "engineering guess")] = Field(
        1.0, ge=-10_000, le=10_000, description="air in the tube that is not configured"
    )

    @classmethod
    def fitted(cls, config: Setup) -> FittedKey | None:
        """Return the volume of the tube, which a valve fills."""
        supply = config.supply
        if supply is None or supply.source == "ideal":
            return None
        return FittedKey("supply.tube_cm3", supply.tube_cm3, 0.01, 10_000)

    def changes(self, supply: AirLine) -> Mapping[str, float]:
        return {"tube_cm3": max(supply.tube_cm3 + self.offset_cm3, 0.01)}

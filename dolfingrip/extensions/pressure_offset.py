"""A regulator whose zero is off."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Flow, LabNumber, Prior
from dolfingrip.extensions.kinds import MANOMETER, SupplyStage


class PressureOffset(SupplyStage):
    """A regulator whose zero is off.

    p_cavity = p_regulator + offset, at all times. So the angle counts from the shape at a
    cavity pressure of the offset.

    Prior: 0 ± 3 kPa, an ordinary error of regulators' zeros.
    Fingerprint: the pressure axis is shifted. There is a force at no pressure (0.01 N for 1 kPa),
    and the force changes by the offset times its slope. The angle is 0 at first in any case, so it
    changes only as its slope does, by 0.2 % at most.
    Confused with: the force's offset, the plate's gap.
    """

    place: ClassVar = 2
    told: ClassVar = LabNumber("pressure_offset_kPa", 2.0, "of the regulator's zero")
    checks: ClassVar = (DirectCheck(MANOMETER, 10.0, {"offset_kPa": 0.3}),)

    offset_kPa: Annotated[float, Prior(0.0, 3.0, "regulators, ±3 kPa")] = Field(
        1.0, ge=-100, le=100, description="cavity pressure at a regulator pressure of 0"
    )

    def outlet_kPa(self, flow: Flow) -> float:
        return flow.inlet_kPa + self.offset_kPa

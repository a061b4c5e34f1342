"""A regulator whose scale is off."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Flow, LabNumber, Prior
from dolfingrip.extensions.kinds import MANOMETER, SupplyStage
from dolfingrip.sections.section import Ratio


class PressureGain(SupplyStage):
    """A regulator whose scale is off.

    p_cavity = gain · p_regulator.

    Prior: 1 ± 0.015, since regulators are within 1 to 2 % of full scale.
    Fingerprint: the pressure axis of angle and force is stretched: for 2 %, angles are 1.9 to 2.2 %
    and forces 2.1 to 3.0 % higher. The bellows' and the plate's first touch and the turning point
    of the force come at another pressure reading.
    Confused with: the modulus together with the force's gain. Without gravity the three cannot be
    told apart: moduli times c, pressure gain times c and force gain by 1/c change no reading.
    """

    place: ClassVar = 1
    neutral: ClassVar = {"gain": 1.0}
    told: ClassVar = LabNumber("pressure_gain", 0.015, "relative, of the regulator's scale")
    checks: ClassVar = (DirectCheck(MANOMETER, 10.0, {"gain": 0.0025}),)

    gain: Annotated[Ratio, Prior(1.0, 0.015, "regulators, ±1 to 2 %", positive=True)] = Field(
        1.02, gt=0, le=10, description="cavity pressure by regulator pressure"
    )

    def outlet_kPa(self, flow: Flow) -> float:
        return self.gain * flow.inlet_kPa

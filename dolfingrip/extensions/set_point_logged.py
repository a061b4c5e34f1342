"""A log of set points, which the pressure follows late."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Flow, Prior
from dolfingrip.extensions.kinds import SupplyStage, lagging


class SetPointLogged(SupplyStage):
    """A log of set points, which the pressure follows late.

    τ dp_out/dt = p_in − p_out, a regulator's response, integrated exactly for a p_in that is linear
    in each load step. It starts at rest. As τ goes to 0, p_out goes to p_in − τ dp_in/dt. In a step
    of no duration nothing flows, and with τ = 0 the outlet is the inlet. Valve, tube and cavity
    that fill are no such response: the table ``[supply]`` has them, behind it.

    Prior: 0.3 ± 0.3 s, for a regulator, and a metre of tube of 2 to 4 mm where there is no
    ``[supply]`` (engineering guess).
    Fingerprint: angle and force lag behind the logged pressure by rate · τ. Loading and unloading
    form a loop, at 125 kPa ±23 % of the angle at 100 kPa/s and ±0.5 % at 2 kPa/s. It closes within
    a few τ of a wait and vanishes at slow rates.
    Confused with: viscoelasticity, which creeps at constant pressure over longer times; a sensor of
    the angle that lags, which leaves the force as it is; a tube behind the gauge, through which a
    soft, large cavity fills later than a small one.
    """

    place: ClassVar = 3
    clock: ClassVar = True
    checks: ClassVar = (
        DirectCheck(
            "a pressure sensor at the finger beside the regulator's, along a fast ramp", 15.0,
            {"tau_s": 0.02},
        ),
    )  # fmt: skip

    tau_s: Annotated[float, Prior(0.3, 0.3, "engineering guess", positive=True)] = Field(
        0.3, ge=0, le=10_000, description="time constant of the response"
    )

    def outlet_kPa(self, flow: Flow) -> float:
        inlet, outlet_kPa = (flow.inlet_before_kPa, flow.inlet_kPa), flow.outlet_before_kPa
        return lagging(self.tau_s, flow.step_s, *inlet, outlet_kPa)

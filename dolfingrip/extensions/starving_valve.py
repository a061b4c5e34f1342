"""A valve that lets through less or more than configured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, FittedKey, LabNumber, Prior, Setup
from dolfingrip.extensions.kinds import AirLineChange
from dolfingrip.sections.section import Ratio
from dolfingrip.sections.supply import AirLine


class StarvingValve(AirLineChange):
    """A valve that lets through more or less than configured.

    C ← c C, the sonic conductance of the valve by ISO 6358, and of the exhaust where that is the
    same valve.

    Prior: 1 ± 0.15, between valves of a data sheet and with a supply that sags (engineering guess).
    Fingerprint: filling takes 1/c of the time, by a ramp where the valve is choked; waits
    untouched.
    Confused with: dead volume, which slows down the exhaust as well; a leak, which stays in waits.
    """

    neutral: ClassVar = {"factor": 1.0}
    either: ClassVar = "more or less"
    told: ClassVar = LabNumber("valve_conductance", 0.15, "relative, of the valve")
    checks: ClassVar = (
        DirectCheck("time the filling of a bottle of known volume", 10.0, {"factor": 0.02}),
    )

    factor: Annotated[Ratio, Prior(1.0, 0.15, "engineering guess", positive=True)] = Field(
        0.8, gt=0, le=1000, description="true conductance by the configured one"
    )

    @classmethod
    def fitted(cls, config: Setup) -> FittedKey | None:
        """Return the conductance of the valve, where the source has one."""
        supply = config.supply
        if supply is None or supply.source not in ("pump", "tank"):
            return None
        return FittedKey("supply.valve_dm3_per_s_bar", supply.valve_dm3_per_s_bar, 1e-9, 100)

    def changes(self, supply: AirLine) -> Mapping[str, float]:
        return {"valve_dm3_per_s_bar": self.factor * supply.valve_dm3_per_s_bar}

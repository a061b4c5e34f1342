"""A gauge that stands nearer to the source than configured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Prior, Setup
from dolfingrip.extensions.kinds import MANOMETER, AirLineChange
from dolfingrip.sections.section import Ratio
from dolfingrip.sections.supply import AirLine


class GaugeAtTheSource(AirLineChange):
    """A gauge that stands nearer to the source than configured.

    ``supply.gauge_part`` ← g + s (1 − g): s = 1 is a gauge at the valve, with all of the tube's
    resistance between it and the cavity.

    Prior: s = 0.5 ± 0.5: where a board has its gauge is seldom told (engineering guess).
    Fingerprint: the valve closes, or opens its exhaust, before the cavity has the pressure that the
    gauge shows: filling and venting end later, and a cavity that leaks never has it.
    Confused with: a valve or a tube that lets through less; a leak, in waits alone.
    """

    checks: ClassVar = (DirectCheck(MANOMETER, 10.0, {"share": 0.05}),)

    share: Annotated[Ratio, Prior(0.5, 0.5, "engineering guess", positive=True)] = Field(
        1.0, ge=0, le=1, description="of the way from the configured place to the valve"
    )

    @classmethod
    def possible(cls, config: Setup) -> bool:
        """Return whether a gauge that is not at the valve controls it.

        Args:
            config: of the body that it acts on.
        """
        supply = config.supply
        return supply is not None and supply.source in ("pump", "tank") and supply.gauge_part < 1

    def changes(self, supply: AirLine) -> Mapping[str, float]:
        return {"gauge_part": supply.gauge_part + self.share * (1 - supply.gauge_part)}

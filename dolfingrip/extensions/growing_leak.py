"""A hole in the cavity that grows with the number of cycles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import AirLineChange
from dolfingrip.sections.supply import AirLine


class GrowingLeak(AirLineChange):
    """A hole in the cavity that grows with the number of cycles.

    Its area is that of the leak + a log₁₀ N in the cycle N, the one that the protocol tells: a
    crack that opens by the same area with each tenfold number of cycles. The first one is tight.

    Prior: 0.01 ± 0.01 mm² for each decade (engineering guess).
    Fingerprint: the cavity falls short of the gauge's pressure by more and more, and empties faster
    than it fills; nothing without pressure.
    Confused with: a leak, in one cycle alone; fatigue, whose angles grow.
    """

    clock: ClassVar = True
    by_decades: ClassVar = True

    area_mm2: Annotated[float, Prior(0.01, 0.01, "engineering guess", positive=True)] = Field(
        0.01, ge=0, le=50, description="by which it grows in a decade of cycles"
    )

    def changes(self, supply: AirLine) -> Mapping[str, float]:
        return {"leak_growth_mm2": supply.leak_growth_mm2 + self.area_mm2}

"""A hole in the cavity."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import AirLineChange
from dolfingrip.sections.supply import AirLine


class Leak(AirLineChange):
    """A hole in the cavity, through which its air is lost.

    A round hole of this area + that of ``supply.leak_mm``, which is choked above 90 kPa.

    Prior: 0.02 ± 0.02 mm², a pinhole of 0.16 mm in a print or a seam (engineering guess).
    Fingerprint: the cavity never has the whole pressure of the gauge, by a part that grows with the
    pressure and with the tube's resistance, and it empties faster than it fills.
    Confused with: a regulator's gain, in waits alone; a log of set points, in ramps alone.
    """

    curved: ClassVar = True  # the last air leaves even through a small hole

    checks: ClassVar = (
        DirectCheck("close the valve and time how the pressure falls", 5.0, {"area_mm2": 0.002}),
    )

    area_mm2: Annotated[float, Prior(0.02, 0.02, "engineering guess", positive=True)] = Field(
        0.02, ge=0, le=50, description="of the hole"
    )

    def changes(self, supply: AirLine) -> Mapping[str, float]:
        return {"leak_mm": math.sqrt(supply.leak_mm**2 + 4 * self.area_mm2 / math.pi)}

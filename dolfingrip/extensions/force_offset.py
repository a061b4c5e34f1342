"""A force sensor whose zero is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import FORCE
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import WEIGHT, Instrument


class ForceOffset(Instrument):
    """A force sensor whose zero is off.

    F_displayed = F + offset.

    Prior: 0 ± 0.02 N, for a load cell of some 10 N that was zeroed by hand (engineering guess).
    Fingerprint: the force is higher by the same amount at all pressures, and without pressure;
    the angle stays.
    Confused with: the plate's gap and the pressure's offset. With either of them the force is
    still 0 as long as nothing touches.
    """

    place: ClassVar = 2
    checks: ClassVar = (DirectCheck(WEIGHT, 5.0, {"offset_N": 0.005}),)
    channel: ClassVar = FORCE

    offset_N: Annotated[float, Prior(0.0, 0.02, "engineering guess")] = Field(
        0.02, ge=-1000, le=1000, description="displayed force at no force"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        return true[self.channel.name] + self.offset_N

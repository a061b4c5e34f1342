"""An angle that does not start at zero."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import SQUARE, Instrument


class AngleOffset(Instrument):
    """An angle whose zero is off.

    α_displayed = α + offset. It arises if the finger at rest was not measured well.

    Prior: 0 ± 0.5° (engineering guess).
    Fingerprint: the angle is higher by the same amount at all pressures, and without pressure;
    the force stays.
    Confused with: a permanent set from before the first reading; sag under gravity.
    """

    place: ClassVar = 3
    checks: ClassVar = (DirectCheck(SQUARE, 5.0, {"offset_deg": 0.1}),)
    channel: ClassVar = ANGLE

    offset_deg: Annotated[float, Prior(0.0, 0.5, "engineering guess")] = Field(
        0.5, ge=-360, le=360, description="displayed angle at rest"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        return true[self.channel.name] + self.offset_deg

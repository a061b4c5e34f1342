"""A force sensor whose scale is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import FORCE
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import WEIGHT, Instrument
from dolfingrip.sections.section import Ratio


class ForceGain(Instrument):
    """A force sensor that reads too much or too little.

    F_displayed = gain · F.

    Prior: 1 ± 0.01, for a calibrated load cell of some 10 N (engineering guess).
    Fingerprint: the force changes by one factor at all pressures; the angle stays.
    Confused with: the modulus together with the pressure's gain (see pressure_gain); a plate
    that is tilted.
    """

    either: ClassVar = "too much or too little"
    place: ClassVar = 1
    neutral: ClassVar = {"gain": 1.0}
    checks: ClassVar = (DirectCheck(WEIGHT, 5.0, {"gain": 0.002}),)
    channel: ClassVar = FORCE

    gain: Annotated[Ratio, Prior(1.0, 0.01, "engineering guess", positive=True)] = Field(
        1.02, gt=0, le=10, description="displayed force by true force"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        return self.gain * true[self.channel.name]

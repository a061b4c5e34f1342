"""A camera whose scale differs by direction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import SQUARE, Instrument
from dolfingrip.sections.section import Ratio


class AngleGain(Instrument):
    """An angle that is measured too large or too small.

    α_displayed = gain · α. A camera that does not look along the axis of bending has such a gain.

    Prior: 1 ± 0.02 (engineering guess).
    Fingerprint: the angle changes by one factor at all pressures; the force stays.
    Confused with: the angle's definition, which does nearly the same; the thickness of the base
    layer, which changes the force a little, too.
    """

    either: ClassVar = "too large or too small"
    place: ClassVar = 2
    neutral: ClassVar = {"gain": 1.0}
    checks: ClassVar = (DirectCheck(SQUARE, 5.0, {"gain": 0.003}),)
    channel: ClassVar = ANGLE

    gain: Annotated[Ratio, Prior(1.0, 0.02, "engineering guess", positive=True)] = Field(
        1.02, gt=0, le=10, description="displayed angle by true angle"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        return self.gain * true[self.channel.name]

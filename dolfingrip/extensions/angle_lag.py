"""A sensor of the angle that lags."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE, TIME
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import Instrument, lagging


class AngleLag(Instrument):
    """A camera or an inertial sensor whose filter shows the angle late.

    τ dα_displayed/dt = α − α_displayed, with an α that is linear between readings. It starts at
    rest.

    Prior: 0.2 ± 0.2 s, the filter of an inertial sensor, or a moving mean of a camera's pictures
    (engineering guess).
    Fingerprint: the angle lags by rate · τ, so loading and unloading form a loop that closes within
    a few τ of a wait and vanishes at slow rates; force untouched.
    Confused with: a line that lags, which moves the force as well; viscoelasticity, which creeps
    over longer times.
    """

    place: ClassVar = 2
    channel: ClassVar = ANGLE
    clock: ClassVar = True
    checks: ClassVar = (
        DirectCheck(
            "a camera's angle beside the sensor's, along a fast ramp", 15.0, {"tau_s": 0.02}
        ),
    )

    tau_s: Annotated[float, Prior(0.2, 0.2, "engineering guess", positive=True)] = Field(
        0.2, ge=0, le=10_000, description="time constant of the filter"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        shown = []
        time_s = before = behind = 0.0
        for moment_s, now in zip(true[TIME.name], true[ANGLE.name], strict=True):
            behind = lagging(self.tau_s, moment_s - time_s, before, now, behind)
            time_s, before = moment_s, now
            shown.append(behind)
        return np.array(shown)

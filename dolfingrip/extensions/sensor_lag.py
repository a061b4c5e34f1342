"""A sensor of motion that lags."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import TIME
from dolfingrip.extensions.camera import in_picture
from dolfingrip.extensions.effect import DirectCheck, Effect, Prior
from dolfingrip.extensions.kinds import lagging
from dolfingrip.sections.fixture import Camera


class SensorLag(Effect):
    """A camera or an inertial sensor whose filter shows angles and places late.

    τ dy_displayed/dt = y − y_displayed, with a y that is linear between readings. It starts at
    what it shows first.

    Prior: 0.2 ± 0.2 s, the filter of an inertial sensor, or a moving mean of a camera's pictures
    (engineering guess).
    Fingerprint: places and angles lag by rate · τ, so loading and unloading form a loop that closes
    within a few τ of a wait and vanishes at slow rates; force untouched. A swing is shown late and
    smaller by 1/√(1 + (ω τ)²), all of its frequencies and ratios as they are.
    Confused with: a line that lags, which moves the force as well; viscoelasticity, which creeps
    over longer times; a camera's clock, which is late by one time at all frequencies.
    """

    kind: ClassVar = "measurement"
    felt_by: ClassVar = ("finger",)
    place: ClassVar = 2
    clock: ClassVar = True
    checks: ClassVar = (
        DirectCheck(
            "a camera's angle beside the sensor's, along a fast ramp", 15.0, {"tau_s": 0.02}
        ),
    )

    tau_s: Annotated[float, Prior(0.2, 0.2, "engineering guess", positive=True)] = Field(
        0.2, ge=0, le=10_000, description="time constant of the filter"
    )

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        return {name: self._behind(true[TIME.name], true[name]) for name in in_picture(true)}

    def _behind(self, time_s: np.ndarray, true: np.ndarray) -> np.ndarray:
        shown = [float(true[0])]
        for i, step_s in enumerate(np.diff(time_s)):
            shown.append(lagging(self.tau_s, step_s, true[i], true[i + 1], shown[-1]))
        return np.array(shown)

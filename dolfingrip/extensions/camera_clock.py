"""A camera whose clock is not that of the pressure's log."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import TIME
from dolfingrip.extensions.camera import CameraError, in_picture
from dolfingrip.extensions.effect import DirectCheck, LabNumber, Prior
from dolfingrip.sections.fixture import Camera


class CameraClock(CameraError):
    """A camera that is late or early.

    y_displayed(t) = y(t − late), with a y that is linear between readings and beyond the last one.
    Before the first one it is that of the first.

    Prior: 0 ± 0.3 s, a shift that was found by the motion alone (engineering guess); `dolfingrip
    track` tells it by how it brought video and log together.
    Fingerprint: places and angles lag by rate · late, so loading and unloading form a loop that
    vanishes at slow rates; in a wait they stand still after this time. Forces stay.
    Confused with: a line that lags, which moves the force as well and ends a wait smoothly.
    """

    either: ClassVar = "late or early"
    place: ClassVar = 7
    clock: ClassVar = True
    checks: ClassVar = (DirectCheck("a lamp that camera and log both see", 10.0, {"late_s": 0.02}),)
    told_by: ClassVar = {
        "late_s": LabNumber("camera_clock_s", 0.0, "of a camera's clock against the log's")
    }
    replaces: ClassVar = ("sensor_lag",)

    late_s: Annotated[float, Prior(0.0, 0.3, "engineering guess")] = Field(
        0.3, ge=-1000, le=1000, description="age of what is displayed"
    )

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        time_s = true[TIME.name]
        seen = time_s - self.late_s
        shown = {}
        for name in in_picture(true):
            value = true[name]
            shown[name] = np.interp(seen, time_s, value)
            if len(value) > 1 and time_s[-1] > time_s[-2]:
                rate = (value[-1] - value[-2]) / (time_s[-1] - time_s[-2])
                shown[name] += rate * np.maximum(seen - time_s[-1], 0.0)
        return shown

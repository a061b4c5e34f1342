"""A camera whose scale is off."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.extensions.camera import SHEET, CameraError
from dolfingrip.extensions.effect import DirectCheck, LabNumber, Prior
from dolfingrip.sections.fixture import Camera
from dolfingrip.sections.section import Ratio


class CameraScale(CameraError):
    """A camera that shows lengths too long or too short.

    (x, z)_displayed = gain · (x, z). A length that was measured in another plane than that of the
    points has such a gain: 10 mm at 400 mm are 2.5 %.

    Prior: 1 ± 0.01 (engineering guess); `dolfingrip track` tells it by its calibration.
    Fingerprint: all places are farther from the clamp by one factor; angles and forces stay, but
    the points that are followed are nearer to the clamp than they seem.
    Confused with: the modulus, where only points near the clamp are followed.
    """

    either: ClassVar = "too long or too short"
    place: ClassVar = 5
    neutral: ClassVar = {"gain": 1.0}
    checks: ClassVar = (DirectCheck(SHEET, 15.0, {"gain": 0.002}),)
    told_by: ClassVar = {
        "gain": LabNumber("camera_scale", 0.0, "relative, of the scale of a camera")
    }

    gain: Annotated[Ratio, Prior(1.0, 0.01, "engineering guess", positive=True)] = Field(
        1.01, gt=0, le=10, description="displayed lengths by true lengths"
    )

    def shown_mm(self, places_mm: np.ndarray, camera: Camera) -> np.ndarray:
        return self.gain * places_mm

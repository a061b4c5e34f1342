"""A camera whose places and angles do not start at zero."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE, CHORD_ANGLE
from dolfingrip.extensions.camera import SHEET, CameraError
from dolfingrip.extensions.effect import DirectCheck, LabNumber, Prior
from dolfingrip.sections.fixture import Camera

PLACE: Final = LabNumber("camera_zero_mm", 0.0, "of where the clamp is in the picture, each way")


class CameraZero(CameraError):
    """A camera whose zero is off.

    (x, z)_displayed = (x, z) + offset, α_displayed = α + angle. The clamp is somewhat beside where
    it was pointed at, and the finger at rest was not measured well.

    Prior: 0 ± 0.5 mm and 0 ± 0.5° (engineering guesses); `dolfingrip track` tells them by its
    calibration.
    Fingerprint: points are followed that are nearer to the clamp, or farther from the back, than
    they seem: places are off by the offset less the offset turned with the finger, nothing at rest.
    The angle is higher by the same amount at all pressures; the force stays.
    Confused with: a permanent set from before the first reading; sag under gravity.
    """

    place: ClassVar = 6
    neutral: ClassVar = {"x_mm": 0.0, "z_mm": 0.0, "angle_deg": 0.0}
    checks: ClassVar = (DirectCheck(SHEET, 15.0, {"x_mm": 0.3, "z_mm": 0.3, "angle_deg": 0.1}),)
    told_by: ClassVar = {
        "x_mm": PLACE, "z_mm": PLACE,
        "angle_deg": LabNumber("camera_zero_deg", 0.0, "of a camera's angle at rest"),
    }  # fmt: skip
    replaces: ClassVar = ("angle_offset",)

    x_mm: Annotated[float, Prior(0.0, 0.5, "engineering guess")] = Field(
        0.0, ge=-100, le=100, description="displayed x of the clamp"
    )
    z_mm: Annotated[float, Prior(0.0, 0.5, "engineering guess")] = Field(
        0.0, ge=-100, le=100, description="displayed z of the clamp"
    )
    angle_deg: Annotated[float, Prior(0.0, 0.5, "engineering guess")] = Field(
        0.5, ge=-360, le=360, description="displayed angle at rest"
    )

    def shown_mm(self, places_mm: np.ndarray, camera: Camera) -> np.ndarray:
        return places_mm + np.array([self.x_mm, self.z_mm])

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        shown = super().reading(true, camera)
        names = (ANGLE.name, CHORD_ANGLE.name)
        return {k: v + self.angle_deg if k in names else v for k, v in shown.items()}

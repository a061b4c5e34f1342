"""A camera that does not look squarely at the plane of bending."""

from __future__ import annotations

from typing import Annotated, ClassVar, Final

import numpy as np
from pydantic import Field

from dolfingrip.extensions.camera import SHEET, CameraError
from dolfingrip.extensions.effect import DirectCheck, LabNumber, Prior
from dolfingrip.extensions.kinds import SQUARE
from dolfingrip.sections.fixture import Camera

TOLD: Final = LabNumber("camera_tilt_deg", 0.0, "of a camera's axis, about z and about x")


class CameraTilt(CameraError):
    """A camera that was tilted.

    (x, z)_displayed ← (q·e₁, q·e₂)/(1 − q·n/D), the central projection of a plane (Hartley &
    Zisserman, Multiple View Geometry, 2004, section 8.1). q is the place from the one in the
    picture's middle, D (``camera.distance_mm``) the camera's distance. With θ about z and φ about x
    the axis towards the camera is n = (sin θ cos φ, cos θ cos φ, sin φ), and those of the picture
    are e₁ = (cos θ, −sin θ, 0) and e₂ = (−sin θ sin φ, −cos θ sin φ, cos φ). Places count from the
    shown clamp along the shown line of the markers at rest. They are by the length that told the
    scale (``camera.scale_mm``). Without ``camera.distance_mm`` the camera is far away. Angles are
    those of shown lines.

    Prior: 0 ± 2°, a camera that was aimed squarely by eye (engineering guess); `dolfingrip track`
    tells it by its calibration.
    Fingerprint: what bends towards the camera is shown larger, by 1.4 % at 40 mm for 8° from
    400 mm; lengths across the axis of the tilt are shorter, by 1 % for 8°; forces stay.
    Confused with: the camera's scale, where the camera is far away; a modulus, by angles alone.
    """

    place: ClassVar = 4
    neutral: ClassVar = {"about_z_deg": 0.0, "about_x_deg": 0.0}
    checks: ClassVar = (
        DirectCheck(SHEET, 15.0, {"about_z_deg": 0.5, "about_x_deg": 0.5}),
        DirectCheck(SQUARE, 5.0, {"about_z_deg": 2.0, "about_x_deg": 2.0}),
    )
    told_by: ClassVar = {"about_z_deg": TOLD, "about_x_deg": TOLD}
    replaces: ClassVar = ("angle_gain",)

    about_z_deg: Annotated[float, Prior(0.0, 2.0, "engineering guess")] = Field(
        2.0, ge=-60, le=60, description="about the finger's axis at rest"
    )
    about_x_deg: Annotated[float, Prior(0.0, 2.0, "engineering guess")] = Field(
        0.0, ge=-60, le=60, description="about the direction of bending"
    )

    def shown_mm(self, places_mm: np.ndarray, camera: Camera) -> np.ndarray:
        markers = camera.markers if isinstance(camera.markers, tuple) else ()
        line = float(np.mean([x for x, _ in markers])) if markers else 0.0
        clamp, low, high = self._projected(np.array([[0.0, 0.0], [line, 0], [line, 1]]), camera)
        x, z = (high - low) / np.linalg.norm(high - low)
        size = 1.0
        if camera.scale_mm is not None:
            ends = np.array(camera.scale_mm)
            lengths = [
                float(np.linalg.norm(a - b)) for a, b in (ends, self._projected(ends, camera))
            ]
            size = lengths[0] / lengths[1]
        turned = np.array([[z, -x], [x, z]])
        return np.asarray(size * (self._projected(places_mm, camera) - clamp) @ turned.T)

    def _projected(self, places_mm: np.ndarray, camera: Camera) -> np.ndarray:
        """Places (…, 2) in the picture, by the scale in its middle."""
        off = places_mm - np.array(camera.centre_mm or (0.0, 0.0))
        by_z, by_x = np.radians([self.about_z_deg, self.about_x_deg])
        across = off @ [np.cos(by_z), 0.0]
        along = off @ [-np.sin(by_z) * np.sin(by_x), np.cos(by_x)]
        nearer = off @ [np.sin(by_z) * np.cos(by_x), np.sin(by_x)]
        deep = 1 - nearer / (camera.distance_mm or np.inf)
        return np.stack([across / deep, along / deep], axis=-1)

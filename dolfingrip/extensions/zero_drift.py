"""Sensors whose zeros wander."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE, FORCE, TIME
from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.sections.fixture import Camera


class ZeroDrift(Effect):
    """Sensors of force and angle whose zeros wander.

    F_displayed = F + rate · t since the start, and so the angle at a rate of its own.

    Prior: 0 ± 1e-4 N/s, a load cell of some 10 N that warms up, and 0 ± 0.002 deg/s, an inertial
    sensor's gyroscope (engineering guesses).
    Fingerprint: a force, or an angle, that grows with time alone, at no pressure, too.
    Confused with: viscoelasticity during a wait (which moves both together), drift of the modulus.
    """

    kind: ClassVar = "measurement"
    neutral: ClassVar = {"force_N_per_s": 0.0, "angle_deg_per_s": 0.0}
    place: ClassVar = 3
    clock: ClassVar = True

    force_N_per_s: Annotated[float, Prior(0.0, 1e-4, "engineering guess")] = Field(
        1e-4, ge=-1000, le=1000, description="change of the displayed force with time"
    )
    angle_deg_per_s: Annotated[float, Prior(0.0, 0.002, "engineering guess")] = Field(
        0.0, ge=-1000, le=1000, description="change of the displayed angle with time"
    )

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        rates = {FORCE.name: self.force_N_per_s, ANGLE.name: self.angle_deg_per_s}
        # a free finger's row has no force, and a coupon's row has no angle
        return {name: true[name] + rate * true[TIME.name]
                for name, rate in rates.items() if name in true}  # fmt: skip

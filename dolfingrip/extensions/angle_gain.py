"""A camera whose scale differs by direction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior


class AngleGain(Effect):
    """An angle that is measured too large or too small.

    α_displayed = gain · α, as by a camera that does not look along the axis of bending.

    Prior: 1 ± 0.02 (engineering guess).
    Fingerprint: angle by one factor at all pressures, force untouched.
    Confused with: the angle's definition, nearly the same; base-layer thickness, which changes
    the force a little.
    """

    kind: ClassVar = "measurement"
    neutral: ClassVar = {"gain": 1.0}

    gain: Annotated[float, Prior(1.0, 0.02, "engineering guess", positive=True)] = Field(
        1.02, gt=0, le=10, description="displayed angle by true angle"
    )

    def reading(self, true: Mapping[str, float]) -> Mapping[str, float]:
        return {"angle_deg": self.gain * true["angle_deg"]} if "angle_deg" in true else {}

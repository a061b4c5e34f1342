"""An angle that does not start at zero."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior


class AngleOffset(Effect):
    """An angle whose zero is off.

    α_displayed = α + offset, as where the pose at rest was not measured well.

    Prior: 0 ± 0.5° (engineering guess).
    Fingerprint: the same angle more at all pressures, and at none; force untouched.
    Confused with: permanent set from before the first reading, sag.
    """

    kind: ClassVar = "measurement"
    neutral: ClassVar = {"offset_deg": 0.0}

    offset_deg: Annotated[float, Prior(0.0, 0.5, "engineering guess")] = Field(
        0.5, ge=-360, le=360, description="displayed angle at rest"
    )

    def reading(self, true: Mapping[str, float]) -> Mapping[str, float]:
        return {"angle_deg": true["angle_deg"] + self.offset_deg} if "angle_deg" in true else {}

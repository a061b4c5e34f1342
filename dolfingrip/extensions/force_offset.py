"""A force sensor whose zero is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior


class ForceOffset(Effect):
    """A force sensor whose zero is off.

    F_displayed = F + offset.

    Prior: 0 ± 0.02 N, a load cell of some 10 N tared by hand (engineering guess).
    Fingerprint: the same force more at all pressures, and at none; angle untouched.
    Confused with: the plate's gap, the pressure's offset (both leave a force of 0 at no contact).
    """

    kind: ClassVar = "measurement"
    neutral: ClassVar = {"offset_N": 0.0}

    offset_N: Annotated[float, Prior(0.0, 0.02, "engineering guess")] = Field(
        0.02, ge=-1000, le=1000, description="displayed force at no force"
    )

    def reading(self, true: Mapping[str, float]) -> Mapping[str, float]:
        return {"force_N": true["force_N"] + self.offset_N} if "force_N" in true else {}

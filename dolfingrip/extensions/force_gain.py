"""A force sensor whose scale is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior


class ForceGain(Effect):
    """A force sensor whose scale is off.

    F_displayed = gain · F.

    Prior: 1 ± 0.01, a calibrated load cell of some 10 N (engineering guess).
    Fingerprint: force by one factor at all pressures, angle untouched.
    Confused with: the modulus together with the pressure's gain (see pressure_gain); a plate
    that is tilted.
    """

    kind: ClassVar = "measurement"
    neutral: ClassVar = {"gain": 1.0}

    gain: Annotated[float, Prior(1.0, 0.01, "engineering guess", positive=True)] = Field(
        1.02, gt=0, le=10, description="displayed force by true force"
    )

    def reading(self, true: Mapping[str, float]) -> Mapping[str, float]:
        return {"force_N": self.gain * true["force_N"]} if "force_N" in true else {}

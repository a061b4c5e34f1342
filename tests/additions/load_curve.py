"""An effect that a laboratory knows of its own load cell: not part of the package."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import FORCE
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import Instrument


class LoadCurve(Instrument):
    """A load cell that reads ever more or ever less as the load grows.

    F_displayed = F + b F².

    Prior: 0 ± 0.01 1/N (an example).
    Fingerprint: the force by a factor that grows with it.
    Confused with: laws that stiffen.
    """

    either: ClassVar = "ever more or ever less"
    channel: ClassVar = FORCE
    checks: ClassVar = (
        DirectCheck("several weights on the load cell", 10.0, {"bend_per_N": 0.0005}),
    )

    bend_per_N: Annotated[float, Prior(0.0, 0.01, "an example")] = Field(
        0.01, ge=-1, le=1, description="b"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        force_N = true[self.channel.name]
        return force_N + self.bend_per_N * force_N**2

"""A made-up effect: a force sensor that is not linear."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.channels import FORCE
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Instrument


class ForceSquare(Instrument):
    """A force that is displayed as F + a F².

    Prior: made up.
    Fingerprint: made up.
    Confused with: nothing.
    """

    kind: ClassVar = "measurement"
    neutral: ClassVar = {"square_per_N": 0.0}
    channel: ClassVar = FORCE
    curved: ClassVar = True

    square_per_N: Annotated[float, Prior(0.1, 0.1, "made up", positive=True)] = Field(
        0.1, ge=0, le=10, description="displayed force less the true one, by its square"
    )

    def displayed(self, true: Mapping[str, float]) -> float:
        """The displayed force (N)."""
        force = true[self.channel.name]
        return force + self.square_per_N * force**2

"""A force sensor whose zero wanders."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import FORCE, TIME
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Instrument


class ForceDrift(Instrument):
    """A force sensor whose zero wanders.

    F_displayed = F + rate · t since the start.

    Prior: 0 ± 1e-4 N/s, a load cell of some 10 N that warms up (engineering guess).
    Fingerprint: a force that grows with time alone, at no pressure, too; angle untouched.
    Confused with: viscoelasticity during a wait (which moves the angle as well), drift of the
    modulus.
    """

    place: ClassVar = 3
    channel: ClassVar = FORCE
    clock: ClassVar = True

    rate_N_per_s: Annotated[float, Prior(0.0, 1e-4, "engineering guess")] = Field(
        1e-4, ge=-1000, le=1000, description="change of the displayed force with time"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        return true[FORCE.name] + self.rate_N_per_s * true[TIME.name]

"""An effect of your own: a force sensor that is not linear, in a file of your own.

    dolfingrip force --plugin examples/own_effect.py --set extensions.own_effect.square_per_N=0.1

A diagnosis with the same --plugin tries it as a cause, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import FORCE
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Instrument


class OwnEffect(Instrument):
    """A force that is displayed as F + a F².

    Prior: a = 0 ± 0.1 1/N (an example).
    Fingerprint: large forces are displayed too large or too small, small ones are right.
    Confused with: the force's gain, where all forces are alike.
    """

    channel: ClassVar = FORCE
    curved: ClassVar = True

    square_per_N: Annotated[float, Prior(0.0, 0.1, "an example")] = Field(
        0.1, ge=-10, le=10, description="displayed force less the true one, by its square"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        force_N = true[FORCE.name]
        return force_N + self.square_per_N * force_N**2

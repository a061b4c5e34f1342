"""The base class of effects on a measurement: an instrument displays one channel wrongly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from dolfingrip.channels import Channel
from dolfingrip.extensions.effect import Effect


class Instrument(Effect):
    """An effect that changes one channel and nothing else.

    Attributes:
        channel: what it displays.
    """

    kind: ClassVar = "measurement"
    channel: ClassVar[Channel]

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        """The values that the instrument displays, (rows,), in the channel's unit.

        Args:
            true: readings of a run so far, by column, (rows,) each in the order of time.
        """
        raise NotImplementedError

    def reading(self, true: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        # a free finger's row has no force, and a coupon's row has no angle
        name = self.channel.name
        return {name: self.displayed(true)} if name in true else {}

"""The base class of effects on a measurement: an instrument displays one channel wrongly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from dolfingrip.channels import Channel
from dolfingrip.extensions.effect import Effect


class Instrument(Effect):
    """An effect that changes one channel and nothing else.

    Attributes:
        channel: what it displays.
    """

    kind: ClassVar = "measurement"
    channel: ClassVar[Channel]

    def displayed(self, true: Mapping[str, float]) -> float:
        """The value that the instrument displays, in the channel's unit.

        Args:
            true: a row of readings, by column.
        """
        raise NotImplementedError

    def reading(self, true: Mapping[str, float]) -> Mapping[str, float]:
        # a free finger's row has no force, and a coupon's row has no angle
        name = self.channel.name
        return {name: self.displayed(true)} if name in true else {}

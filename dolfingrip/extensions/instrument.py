"""What effects on a measurement share: an instrument that displays one column wrongly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from dolfingrip.extensions.effect import Effect


class Instrument(Effect):
    """An effect that changes one column of the readings and nothing else.

    Attributes:
        column: name of that column, with its unit.
    """

    column: ClassVar[str]

    def displayed(self, true: Mapping[str, float]) -> float:
        """What the instrument displays, in the column's unit.

        Args:
            true: a row of readings, by column.
        """
        raise NotImplementedError

    def reading(self, true: Mapping[str, float]) -> Mapping[str, float]:
        # a free finger's row has no force, and a coupon's no angle
        return {self.column: self.displayed(true)} if self.column in true else {}

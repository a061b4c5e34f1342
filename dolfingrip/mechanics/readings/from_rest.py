"""Readings that count from the pose at rest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.mechanics.model.direction import Direction
from dolfingrip.mechanics.readings.reading import Reading


class FromRest(Reading):
    """g(x) − g(x at rest); where g is an angle, beyond half a turn, too.

    :meth:`gradient` and :meth:`by_direction` are those of g at the present state. Its zero moves,
    too, with a parameter: a total derivative is that of g here less that of g at rest, which the
    caller takes of ``raw`` with the model in its state at rest.

    Args:
        raw: g.
        turned_deg: of an angle: what it is to less than half a turn, and with its whole turns; None
            of another reading.

    Attributes:
        raw: as given.
        zero: value of ``raw`` at rest; 0 until :meth:`tare` is called.
    """

    def __init__(self, raw: Reading, turned_deg: Callable[[], float] | None = None) -> None:
        super().__init__(raw.model, raw.column)
        self.raw = raw
        self.zero = 0.0
        self._turned_deg = turned_deg
        self._turned_at_rest_deg = 0.0

    def tare(self) -> None:
        """Take the present pose as the one at rest."""
        self.zero = self.raw.value()
        if self._turned_deg is not None:
            self._turned_at_rest_deg = self._turned_deg()

    def value(self) -> float:
        found = self.raw.value() - self.zero
        if self._turned_deg is not None:
            turned_deg = self._turned_deg() - self._turned_at_rest_deg
            found += 360.0 * round((turned_deg - found) / 360.0)
        return found

    def gradient(self) -> np.ndarray:
        return self.raw.gradient()

    def by_direction(self, direction: Direction) -> float:
        return self.raw.by_direction(direction)

"""Readings that count from the pose at rest."""

from __future__ import annotations

import numpy as np

from dolfingrip.mechanics.model.direction import Direction
from dolfingrip.mechanics.readings.reading import Reading


class FromRest(Reading):
    """g(x) − g(x at rest), continuous from one value to the next where g is an angle.

    :meth:`gradient` and :meth:`by_direction` are those of g at the present state. Its zero moves,
    too, with a parameter: a total derivative is that of g here less that of g at rest, which the
    caller takes of ``raw`` with the model in its state at rest.

    Args:
        raw: g.
        period: of an angle, in its unit; 0 of another reading.

    Attributes:
        raw: as given.
        zero: value of ``raw`` at rest; 0 until :meth:`tare` is called.
    """

    def __init__(self, raw: Reading, period: float = 0.0) -> None:
        super().__init__(raw.model, raw.column)
        self.raw = raw
        self.zero = 0.0
        self._period = period
        self._last = 0.0

    def tare(self) -> None:
        """Take the present pose as the one at rest."""
        self.zero, self._last = self.raw.value(), 0.0

    def value(self) -> float:
        found = self.raw.value() - self.zero
        if self._period:
            found += self._period * round((self._last - found) / self._period)
            self._last = found
        return found

    def gradient(self) -> np.ndarray:
        return self.raw.gradient()

    def by_direction(self, direction: Direction) -> float:
        return self.raw.by_direction(direction)

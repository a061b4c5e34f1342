"""Readings that count from the state at rest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.readings.reading import Reading


class FromRest(Reading):
    """g(x) − g(x at rest); an angle g may be larger than half a turn.

    :meth:`gradient` is the derivative of g at the present state. Its zero also changes with a
    parameter. A total derivative is therefore that of g here less that of g at rest; the caller
    derives ``raw`` with the model in its state at rest.

    Args:
        raw: g.
        turned_deg: for an angle, returns the rotation within half a turn, and that with whole
            turns; None for another reading.

    Attributes:
        raw: the reading g.
        zero: value of ``raw`` at rest; 0 until :meth:`tare` is called.
    """

    def __init__(self, raw: Reading, turned_deg: Callable[[], float] | None = None) -> None:
        super().__init__(raw.model, raw.column)
        self.raw = raw
        self.zero = 0.0
        self._turned_deg = turned_deg
        self._turned_at_rest_deg = 0.0

    def tare(self) -> None:
        """Make the present state the state at rest."""
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

    def add_shape_gradient(self, found: ShapeGradient) -> None:
        self.raw.add_shape_gradient(found)

"""A reading by the softness of the body, from two stops of one run.

Where all moduli are exp(−t) times as large, the body has the shape that it has at exp(t) times the
pressure, and its forces are exp(−t) times those there. So with Y(p) the reading by the pressure,
the reading by the softness t is

    ψ(t) = Y(p exp t), for a force exp(−t) Y(p exp t).

Y is the polynomial through the values and the slopes of two stops, of which the second is at half
the pressure of the first or less. The slope by the pressure is that by all moduli, read backwards.
Beyond half and twice the pressure ψ goes on along its tangents.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import KroghInterpolator

from dolfingrip.meshes.solid import Floats

REACH: Final = math.log(2.0)
"""Softness, in both directions, up to which the polynomial is believed."""


@dataclass(frozen=True, slots=True)
class ReadingAt:
    """A reading at a stop.

    Attributes:
        load: pressure of the stop.
        value: of the reading.
        slope: its derivative by the factor of all moduli; nan where it is not known.
    """

    load: float
    value: float
    slope: float


class Softness:
    """The reading ψ(t) of a body that is softer than the one that was solved.

    Args:
        here: at the stop whose reading it is.
        before: at half its load or less.
        in_proportion: whether the reading grows by the factor by which all moduli and loads grow.

    Attributes:
        slope: ψ'(0), in the reading's unit.
    """

    def __init__(self, here: ReadingAt, before: ReadingAt, *, in_proportion: bool) -> None:
        self.slope = -here.slope
        self._power = float(in_proportion)
        knots: list[tuple[float, float]] = []
        for reading in (before, here):
            part = reading.load / here.load
            knots.append((part, reading.value))
            if part and math.isfinite(reading.slope):
                knots.append((part, (self._power * reading.value - reading.slope) / part))
        self._by_load = KroghInterpolator(*np.array(knots).T)

    def __call__(self, t: Floats) -> Floats:
        """Return the reading.

        Args:
            t: softness, shape (n,).

        Returns:
            ψ, shape (n,).
        """
        inner = np.clip(t, -REACH, REACH)
        part, factor = np.exp(inner), np.exp(-self._power * inner)
        value, slope = (self._by_load.derivative(part, order) for order in (0, 1))
        tangent = factor * (part * slope - self._power * value)
        return factor * value + tangent * (t - inner)

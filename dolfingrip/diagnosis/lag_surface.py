"""A line's lag at any time constant and modulus: exact, as it needs no simulation."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.simulation import line_lag
from dolfingrip.diagnosis.surface import SecantSurface


class LagSurface(SecantSurface):
    """The change by a line that lags, from the base simulation's elastic curve.

    A secant is of one modulus. The pressure behind the line does not depend on it, so that no
    other modulus has that secant at other pressures: a finger 20 % softer than told, behind a line
    that changes its readings by 40 standard deviations, left 17 of them unexplained.

    Args:
        problem: the readings; moduli of its base simulation scale.
        candidate, parameters: as for the secants.
    """

    close: ClassVar[bool] = True

    def change(self, zeta: Vector, factor: float = 1.0) -> Vector:
        """Of the readings, shape (n,)."""
        base = self._problem.base
        found = line_lag.change(base.measurement, base.simulated, self.effect(zeta), factor)
        return self._problem.take(found)

"""A direction of change: the rates of the mesh and of constants with a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dolfinx import fem


@dataclass(frozen=True, slots=True)
class Direction:
    """The rates of the mesh and of constants with a parameter.

    Attributes:
        velocity: velocity of the points of the reference configuration (mm for each unit of the
            parameter), a piecewise linear vector; None if they stay.
        rates: constants of the potential with their rates.
    """

    velocity: fem.Function | None = None
    rates: Sequence[tuple[fem.Constant, float]] = ()

    def rate(self, constant: fem.Constant) -> float:
        """Rate of a constant; 0 if it does not change."""
        return sum(rate for changing, rate in self.rates if changing is constant)

"""What changes with a parameter, and how fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dolfinx import fem


@dataclass(frozen=True, slots=True)
class Direction:
    """What changes with a parameter, and how fast.

    Attributes:
        velocity: of the points of the reference configuration (mm for each unit of the
            parameter), a piecewise linear vector; None where they stay.
        rates: constants of the potential with their rates.
    """

    velocity: fem.Function | None = None
    rates: Sequence[tuple[fem.Constant, float]] = ()

    def rate(self, constant: fem.Constant) -> float:
        """How fast a constant changes."""
        return sum(rate for changing, rate in self.rates if changing is constant)

"""A shape that is turned in its own frame, such as an upright sausage that is laid down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dolfingrip.mechanics.contact.distance import Bounds, Distances, SignedDistance


@dataclass(frozen=True, slots=True)
class TurnedShape:
    """The distance φ(Tᵀ y), with φ of another shape.

    A body whose frame is turned like this starts at the rotation vector 0, about which its motions
    in a plane of symmetry are turns about one axis.

    Attributes:
        shape: the other shape.
        turn: (3, 3) T.
    """

    shape: SignedDistance
    turn: np.ndarray

    @property
    def bounds(self) -> Bounds:
        """Bounds of the other shape; a turn does not change them."""
        return self.shape.bounds

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm) from the turned shape."""
        value, gradient, hessian = self.shape.at(points @ self.turn)
        return Distances(value, gradient @ self.turn.T, self.turn @ hessian @ self.turn.T)

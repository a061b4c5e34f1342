"""Points along a step in which a rigid body turns and moves, in a shape's frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dolfingrip.mechanics.contact.advance import Path
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.mechanics.model.rotation import rotation


class MovingPoints(NamedTuple):
    """y(t) = Q(t) a(t) + b(t) for a fraction t of the step; a and b are linear in t.

    Q is the rotation by θ + t Δθ, or its inverse. With ω = |Δθ| a point's speed stays below
    ω |a| + |a'| + |b'|, and its acceleration below 2 ω² |a| + 2 ω |a'|.

    Attributes:
        arms: (n, 3) a(0) (mm).
        drift: (n, 3) a' (mm).
        place: (3,) b(0) (mm).
        shift: (3,) b' (mm).
        theta: (3,) θ (rad).
        turn: (3,) Δθ (rad).
        back: whether Q is the inverse of the rotation.
    """

    arms: np.ndarray
    drift: np.ndarray
    place: np.ndarray
    shift: np.ndarray
    theta: np.ndarray
    turn: np.ndarray
    back: bool

    def at(self, part: float, shape: SignedDistance) -> Path:
        """Distances from ``shape`` at a fraction of the step, and bounds on the rest of it."""
        turned = rotation(self.theta + part * self.turn)
        if self.back:
            turned = turned.inverse
        arms = self.arms + part * self.drift
        found = shape.at(arms @ turned.matrix.T + (self.place + part * self.shift))
        spin = np.einsum("k,kij->ij", self.turn, turned.first)
        velocity = self.drift @ turned.matrix.T + arms @ spin.T + self.shift
        slope = np.einsum("ni,ni->n", found.gradient, velocity)
        omega, drift = float(np.linalg.norm(self.turn)), np.linalg.norm(self.drift, axis=1)
        lengths = np.linalg.norm(arms, axis=1) + drift  # in the rest of the step, too
        fastest = omega * lengths + drift + float(np.linalg.norm(self.shift))
        return Path(found.value, slope, fastest, 2 * omega**2 * lengths + 2 * omega * drift)

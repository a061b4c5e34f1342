"""The safe part of a step of points towards a shape (conservative advancement).

Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, section 2.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dolfingrip.mechanics.contact.distance import Bounds, SignedDistance
from dolfingrip.mechanics.model.pose import rotation


class Path(NamedTuple):
    """Points at one fraction of a step, in the shape's frame; each (n,), rates by the fraction.

    Attributes:
        distance: φ.
        slope: φ'.
        fastest: bound on the speed in the rest of the step.
        bend: bound on the acceleration in the rest of the step.
    """

    distance: np.ndarray
    slope: np.ndarray
    fastest: np.ndarray
    bend: np.ndarray


@dataclass(frozen=True, slots=True)
class AdvancePolicy:
    """The bound on the approach of points to a shape in a step of Newton's method.

    Attributes:
        kept: part of its distance that each point keeps in a step.
        pieces: largest number of pieces of a step; each is as long as is safe from the end of the
            last one.
    """

    kept: float = 0.1
    pieces: int = 16


def reach(
    at: Callable[[float], Path], bounds: Bounds, policy: AdvancePolicy = AdvancePolicy()
) -> float:
    """The largest safe fraction of a step, 1 or less; each point keeps a part of its distance.

    With a shape's slope L and concavity κ, φ(t) ≥ φ + t φ' − t² (L A + κ v²)/2 as long as φ stays
    within the shape's reach, with bounds v and A on speed and acceleration, and φ(t) ≥ φ − t L v
    anywhere. The step is divided into pieces; each is as long as the better of these lower bounds
    allows.

    Args:
        at: returns the points at a fraction of the step.
        bounds: bounds of the shape.
        policy: the part of its distance that each point keeps, and the number of pieces.
    """
    path = at(0.0)
    if not len(path.distance):
        return 1.0
    least, reached = policy.kept * path.distance, 0.0
    for _ in range(policy.pieces):
        ahead = _ahead(path, least, bounds)
        reached += ahead
        if reached >= 1.0:
            return 1.0
        if ahead < policy.kept * reached:
            break
        path = at(reached)
    return reached


def _ahead(path: Path, least: np.ndarray, bounds: Bounds) -> float:
    """Part of a step, 1 or less, in which all distances certainly stay above their minima."""
    spare = np.maximum(path.distance - least, 0.0)
    curved = bounds.slope * path.bend + bounds.concavity_per_mm * path.fastest**2
    safe = _until_spent(spare, path.slope, curved)
    if np.isfinite(bounds.reach_mm):
        most = bounds.slope * np.maximum(path.fastest, np.finfo(float).tiny)
        with np.errstate(over="ignore"):  # a point that stands still never gets there
            leaves = np.maximum(bounds.reach_mm - path.distance, 0.0) / most
            safe = np.maximum(np.minimum(safe, leaves), spare / most)
    return float(min(safe.min(initial=np.inf), 1.0))


def _until_spent(spare: np.ndarray, slope: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """(n,) smallest positive t at which spare + t slope − t² bend/2 vanishes."""
    root = np.sqrt(slope**2 + 2 * bend * spare)
    below = root - slope
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(below > 0, 2 * spare / below, np.inf)


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

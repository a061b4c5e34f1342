"""Signed distances from rigid shapes, in the shape's own frame, and safe steps towards them.

A step is shortened to its safe part by conservative advancement (Mirtich, Impulse-based Dynamic
Simulation of Rigid Body Systems, 1996, section 2.3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple, Protocol

import numpy as np

from dolfingrip.mechanics.model.pose import rotation


class Distances(NamedTuple):
    """Signed distances (mm) of points, positive outside, and their derivatives by the points.

    Attributes:
        value: (n,).
        gradient: (n, 3), unit vectors away from the shape.
        hessian: (n, 3, 3), 1/mm.
    """

    value: np.ndarray
    gradient: np.ndarray
    hessian: np.ndarray


class Bounds(NamedTuple):
    """Bounds of a distance that hold at any point; bounds on steps follow from them.

    Attributes:
        slope: the distance changes by no more than so many times what the point moves.
        concavity_per_mm: second derivatives along a line are above minus this where distances
            are ``reach_mm`` or less. It is 0 for a convex shape.
        reach_mm: distance up to which the concavity is valid.
        radius_mm: radius of a ball about the origin that contains the shape.
    """

    slope: float = 1.0
    concavity_per_mm: float = 0.0
    reach_mm: float = np.inf
    radius_mm: float = np.inf


class SignedDistance(Protocol):
    """A shape whose distance has a continuous gradient outside."""

    @property
    def bounds(self) -> Bounds:
        """Bounds that hold at any point."""
        ...

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm) from the shape about the origin."""
        ...


@dataclass(frozen=True, slots=True)
class Plane:
    """The half space below a plane through the origin: φ = n · y.

    Attributes:
        normal: (3,) unit vector.
    """

    normal: tuple[float, float, float]

    bounds: ClassVar[Bounds] = Bounds()

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm) from the plane."""
        normal = np.asarray(self.normal)
        count = len(points)
        return Distances(points @ normal, np.tile(normal, (count, 1)), np.zeros((count, 3, 3)))


@dataclass(frozen=True, slots=True)
class Capsule:
    """Points within r of a segment of the z axis.

    The Hessian jumps where the cylinder ends; the gradient does not.

    Attributes:
        radius_mm: r.
        half_length_mm: half the segment's length; the whole is 2 (half length + r) long.
    """

    radius_mm: float
    half_length_mm: float

    @property
    def bounds(self) -> Bounds:
        """Convex."""
        return Bounds(radius_mm=self.half_length_mm + self.radius_mm)

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm) from the capsule."""
        beyond = np.abs(points[:, 2]) > self.half_length_mm
        end = np.clip(points[:, 2], -self.half_length_mm, self.half_length_mm)
        apart = points - np.outer(end, [0.0, 0.0, 1.0])
        felt = np.ones_like(points)
        felt[:, 2] = beyond
        return _from_core(apart, felt, self.radius_mm)


@dataclass(frozen=True, slots=True)
class BentCapsule:
    """Points within r of a circular arc in the plane y = 0: a bent sausage.

    The arc's middle is at (x₀, 0, 0), where it runs along z; its centre lies at x₀ + R. With ρ the
    distance from the arc's axis and a = ρ − R, the distance is √(a² + y²) − r. Beyond its ends it
    is that from a sphere. Its second derivative around the axis is a/(ρ (φ + r)), negative inside
    the bend, and −1/(R − r − φ) at least.

    Attributes:
        radius_mm: r.
        half_length_mm: half the arc's length.
        bend_radius_mm: R, above r.
        place_mm: x₀.
    """

    radius_mm: float
    half_length_mm: float
    bend_radius_mm: float
    place_mm: float = 0.0

    @property
    def bounds(self) -> Bounds:
        """Within half of the way from the skin to the arc's axis."""
        reach = (self.bend_radius_mm - self.radius_mm) / 2
        farthest = abs(self.place_mm) + self.half_length_mm + self.radius_mm
        return Bounds(1.0, 1 / reach, reach, farthest)

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm) from the bent capsule."""
        big = self.bend_radius_mm
        away = points - [self.place_mm + big, 0.0, 0.0]
        rho = np.maximum(np.hypot(away[:, 0], away[:, 2]), np.finfo(float).tiny)
        angle = np.arctan2(away[:, 2], -away[:, 0])
        most = self.half_length_mm / big
        end = np.clip(angle, -most, most)
        nearest = big * np.stack([-np.cos(end), np.zeros_like(end), np.sin(end)], axis=1)
        apart = away - nearest
        value, normal, hessian = _from_core(apart, np.ones_like(points), self.radius_mm)
        # where the nearest point runs along the arc, a/ρ takes the place of 1 in that direction
        along = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
        less = np.where(np.abs(angle) <= most, -big / rho, 0.0)
        less = less / np.maximum(value + self.radius_mm, np.finfo(float).tiny)
        less = np.where(np.isfinite(less), less, 0.0)  # on the axes, far inside and far away
        hessian = hessian + less[:, None, None] * along[:, :, None] * along[:, None, :]
        return Distances(value, normal, hessian)


@dataclass(frozen=True, slots=True)
class RoundedBox:
    """Points within r of a box: a cube with rounded edges, about the origin.

    The Hessian jumps where faces, edges and corners meet; the gradient does not. Deeper inside
    than r there is none.

    Attributes:
        half_mm: half the outer lengths.
        radius_mm: r, above 0 and at most the least half length.
    """

    half_mm: tuple[float, float, float]
    radius_mm: float

    @property
    def bounds(self) -> Bounds:
        """Convex."""
        return Bounds(radius_mm=float(np.linalg.norm(self.half_mm)))

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm) from the box."""
        core = np.asarray(self.half_mm) - self.radius_mm
        apart = points - np.clip(points, -core, core)
        return _from_core(apart, (np.abs(points) > core).astype(float), self.radius_mm)


def _from_core(apart: np.ndarray, felt: np.ndarray, radius_mm: float) -> Distances:
    """Distances from a shape around a core, from vectors to the core's nearest points.

    Args:
        apart: (n, 3) from the core's nearest point to the point.
        felt: (n, 3) 1 along the axes that ``apart`` changes with, else 0.
        radius_mm: distance of the shape's surface from the core.
    """
    length = np.linalg.norm(apart, axis=1)
    length = np.maximum(length, np.finfo(float).tiny)  # within the core there is no direction
    normal = apart / length[:, None]
    across = felt[:, :, None] * np.eye(3) - normal[:, :, None] * normal[:, None, :]
    return Distances(length - radius_mm, normal, across / length[:, None, None])


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


KEPT: Final = 0.1
"""Part of its distance that each point keeps in a step."""

PIECES: Final = 16
"""Largest number of pieces of a step; each is as long as is safe from the end of the last one."""


def reach(at: Callable[[float], Path], bounds: Bounds) -> float:
    """The largest safe fraction of a step, 1 or less; each point keeps a part of its distance.

    With a shape's slope L and concavity κ, φ(t) ≥ φ + t φ' − t² (L A + κ v²)/2 as long as φ stays
    within the shape's reach, with bounds v and A on speed and acceleration, and φ(t) ≥ φ − t L v
    anywhere. The step is divided into pieces; each is as long as the better of these lower bounds
    allows.

    Args:
        at: returns the points at a fraction of the step.
        bounds: bounds of the shape.
    """
    path = at(0.0)
    if not len(path.distance):
        return 1.0
    least, reached = KEPT * path.distance, 0.0
    for _ in range(PIECES):
        ahead = _ahead(path, least, bounds)
        reached += ahead
        if reached >= 1.0:
            return 1.0
        if ahead < KEPT * reached:
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
    """Smallest positive t at which spare + t slope − t² bend/2 vanishes, (n,)."""
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
        distances = shape.at(arms @ turned.matrix.T + (self.place + part * self.shift))
        spin = np.einsum("k,kij->ij", self.turn, turned.first)
        velocity = self.drift @ turned.matrix.T + arms @ spin.T + self.shift
        slope = np.einsum("ni,ni->n", distances.gradient, velocity)
        omega, drift = float(np.linalg.norm(self.turn)), np.linalg.norm(self.drift, axis=1)
        lengths = np.linalg.norm(arms, axis=1) + drift  # in the rest of the step, too
        fastest = omega * lengths + drift + float(np.linalg.norm(self.shift))
        return Path(distances.value, slope, fastest, 2 * omega**2 * lengths + 2 * omega * drift)

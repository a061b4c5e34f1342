"""Signed distances from rigid shapes, in the shape's own frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np


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

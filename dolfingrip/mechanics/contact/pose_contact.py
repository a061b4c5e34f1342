"""Contact by signed distance where a rigid body's pose decides distances: base class and points."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Final, NamedTuple

import numpy as np

from dolfingrip.mechanics.contact.density import BarrierValues, Density
from dolfingrip.mechanics.contact.distance import (
    Distances,
    MovingPoints,
    SignedDistance,
    reach,
)
from dolfingrip.mechanics.contact.tangential import Touching
from dolfingrip.mechanics.model.pose import SIX, Pose, Rotation


class Near(NamedTuple):
    """Points near a shape, at y = Q(θ) a + C c + constant in the shape's frame.

    (c, θ) is the pose of a rigid body. If the points belong to the body, Q is its rotation R and
    C = 1. If the shape belongs to the body, y = Rᵀ(x − c), so Q = Rᵀ and C = −Rᵀ.

    Attributes:
        rows: (n,) numbers of the points.
        arms: (n, 3) a (mm).
        areas: (n,) areas (mm²).
        turned: Q with its derivatives by θ.
        by_centre: (3, 3) C.
        distances: distances from the shape, in its frame.
        barrier: values of the barrier there.
    """

    rows: np.ndarray
    arms: np.ndarray
    areas: np.ndarray
    turned: Rotation
    by_centre: np.ndarray
    distances: Distances
    barrier: BarrierValues

    @property
    def forces(self) -> np.ndarray:
        """Derivatives of Π by the points in the shape's frame (N), (n, 3)."""
        return (self.areas * self.barrier.slope)[:, None] * self.distances.gradient

    @property
    def moment(self) -> np.ndarray:
        """Matrix M (N mm), (3, 3): Q(θ) : M has the derivatives of Π by θ at fixed forces."""
        return np.asarray(self.forces.T @ self.arms)

    @property
    def motion(self) -> np.ndarray:
        """Derivatives of y by the pose, (n, 3, 6)."""
        moving = np.empty((len(self.rows), 3, SIX))
        moving[:, :, :3] = self.by_centre
        moving[:, :, 3:] = np.einsum("kij,nj->nik", self.turned.first, self.arms)
        return moving

    def curved(self, *, convex: bool) -> np.ndarray:
        """Second derivatives of Π by the points in the shape's frame (N/mm), (n, 3, 3).

        Args:
            convex: without the part of the distance's curvature.
        """
        normal = self.distances.gradient
        along = (self.areas * self.barrier.curvature)[:, None, None] * (
            normal[:, :, None] * normal[:, None, :]
        )
        if convex:
            return along
        tension = (self.areas * self.barrier.slope)[:, None, None]
        return np.asarray(along + tension * self.distances.hessian)


def slopes(near: Near) -> np.ndarray:
    """This rank's part of the derivatives of Π by the pose (N; N mm), (6,)."""
    by_centre = (near.forces @ near.by_centre).sum(axis=0)
    return np.concatenate([by_centre, near.turned.slopes(near.moment)])


def curvatures(near: Near, *, convex: bool) -> np.ndarray:
    """This rank's part of the second derivatives of Π by the pose, for constant C, (6, 6).

    Args:
        near: the points.
        convex: without the parts of the distance's and the rotation's curvature.
    """
    moving = near.motion
    within = np.asarray(
        np.einsum(
            "nik,nil->kl", moving, np.einsum("nij,njl->nil", near.curved(convex=convex), moving)
        )
    )
    if not convex:
        within[3:, 3:] += near.turned.curvatures(near.moment)
    return within


AROUND: Final = 2.0
"""Widths of the barrier from a ball around the shape beyond which no point is evaluated: twice that
of an exact distance, because a sampled distance is only nearly as steep."""

WITHIN: Final = 1 + 1e-6
"""Widths of the barrier up to which it is evaluated; it is 0 from 1 on."""


class PoseContact(Touching):
    """Points stay outside a shape. The shape or the points belong to a rigid body.

    Π = Σ A_i b(φ(y_i)) over points with areas A_i. y_i is the place of point i in the frame of the
    shape with the signed distance φ, a function of the body's pose. b is a barrier's energy per
    area.

    Args:
        shape: φ.
        pose: of the body.
        density: b.
        copies: number of meshed parts that make the whole and share the body.
    """

    passes: ClassVar[str]
    """Sentence for a state in which a point lies within the shape."""

    def __init__(self, shape: SignedDistance, pose: Pose, density: Density, copies: int) -> None:
        self.shape = shape
        self.pose = pose
        self.density = density
        self._copies = copies

    @abstractmethod
    def gaps_mm(self, dofs: np.ndarray) -> np.ndarray:
        """Distances of this rank's points from the shape, (n,)."""

    @abstractmethod
    def near(self, dofs: np.ndarray) -> Near:
        """Points within the barrier's width of the shape at the displacement ``dofs``."""

    @abstractmethod
    def _moving(self, dofs: np.ndarray, step: np.ndarray) -> MovingPoints:
        """Points that a step from ``dofs`` may bring near to the shape."""

    def _sum[T](self, local: T) -> T:
        """Sum over the ranks' points; by default each rank has all points."""
        return local

    def _least(self, local: float) -> float:
        """Smallest value over the ranks' points; by default each rank has all points."""
        return local

    def _felt(self, places: np.ndarray) -> tuple[np.ndarray, Distances, BarrierValues]:
        """The points within the barrier's width, with their distances and the barrier there."""
        every = self.shape.at(places)
        rows = np.flatnonzero(every.value < self.density.width_mm * WITHIN)
        distances = Distances(*(values[rows] for values in every))
        return rows, distances, self.density.at(distances.value)

    # -- the potential ---------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part."""
        near = self.near(dofs)
        return float(self._sum(float(near.areas @ near.barrier.energy)))

    def load_N(self, dofs: np.ndarray) -> np.ndarray:
        """Force (N) and moment-like derivative (N mm) on the body, of the whole, (6,)."""
        return -self._copies * np.asarray(self._sum(slopes(self.near(dofs))))

    # -- bounds ----------------------------------------------------------------------------------

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction of ``step`` in which each point keeps a tenth of its distance."""
        moving = self._moving(dofs, step)
        return self._least(reach(lambda part: moving.at(part, self.shape), self.shape.bounds))

    def rejects(self, dofs: np.ndarray) -> str:
        """A state in which a point lies within the shape."""
        least = self._least(float(self.gaps_mm(dofs).min(initial=np.inf)))
        return self.passes if least <= 0 else ""

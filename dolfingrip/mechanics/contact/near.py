"""Points near a shape, and their potential's derivatives by the pose of a rigid body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dolfingrip.mechanics.contact.density import BarrierValues
from dolfingrip.mechanics.contact.distance import Distances
from dolfingrip.mechanics.model.pose import SIX
from dolfingrip.mechanics.model.rotation import Rotation


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
        """(n, 3) derivatives of Π by the points in the shape's frame (N)."""
        return (self.areas * self.barrier.slope)[:, None] * self.distances.gradient

    @property
    def moment(self) -> np.ndarray:
        """(3, 3) M (N mm): Q(θ) : M has the derivatives of Π by θ at fixed forces."""
        return np.asarray(self.forces.T @ self.arms)

    @property
    def motion(self) -> np.ndarray:
        """(n, 3, 6) derivatives of y by the pose."""
        moving = np.empty((len(self.rows), 3, SIX))
        moving[:, :, :3] = self.by_centre
        moving[:, :, 3:] = np.einsum("kij,nj->nik", self.turned.first, self.arms)
        return moving

    def curved(self, *, convex: bool) -> np.ndarray:
        """(n, 3, 3) second derivatives of Π by the points in the shape's frame (N/mm).

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
    """(6,) this rank's part of the derivatives of Π by the pose (N; N mm)."""
    by_centre = (near.forces @ near.by_centre).sum(axis=0)
    return np.concatenate([by_centre, near.turned.slopes(near.moment)])


def curvatures(near: Near, *, convex: bool) -> np.ndarray:
    """(6, 6) this rank's part of the second derivatives of Π by the pose, for constant C.

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

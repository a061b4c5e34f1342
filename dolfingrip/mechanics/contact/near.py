"""Points that feel a rigid body, and the derivatives of their potential by points and pose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dolfingrip.mechanics.contact.density import BarrierValues
from dolfingrip.mechanics.contact.distance import Distances
from dolfingrip.mechanics.model.pose import SIX
from dolfingrip.mechanics.model.rotation import Rotation


class Near(NamedTuple):
    """Points that feel the body.

    Attributes:
        rows: (n,) which of the points.
        arms: (n, 3) from the body's centre, x − c.
        areas: (n,).
        turned: the body's rotation.
        distances: from the body, in its frame.
        barrier: its values there.
    """

    rows: np.ndarray
    arms: np.ndarray
    areas: np.ndarray
    turned: Rotation
    distances: Distances
    barrier: BarrierValues

    @property
    def forces(self) -> np.ndarray:
        """(n, 3) derivatives of Π by the points in the body's frame (N)."""
        return (self.areas * self.barrier.slope)[:, None] * self.distances.gradient

    @property
    def moment(self) -> np.ndarray:
        """(3, 3) M with which R(θ) : M has the derivatives of Π by θ, forces held fast."""
        return np.asarray(self.arms.T @ self.forces)


def slopes(near: Near) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by the near points (n, 3), and this rank's by the pose (6,)."""
    at_points = near.forces @ near.turned.matrix.T
    return at_points, np.concatenate([-at_points.sum(axis=0), near.turned.slopes(near.moment)])


def curvatures(near: Near, *, convex: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Second derivatives: at points (n, 3, 3), with the pose (n, 3, 6), the pose's own (6, 6).

    Args:
        near: the points.
        convex: without the parts of the distance's and the rotation's curvature.
    """
    normal, r = near.distances.gradient, near.turned.matrix
    curved = (near.areas * near.barrier.curvature)[:, None, None] * (
        normal[:, :, None] * normal[:, None, :]
    )
    if not convex:
        tension = (near.areas * near.barrier.slope)[:, None, None]
        curved = curved + tension * near.distances.hessian
    # how the points move in the body's frame as it turns: y_j = R_ij (x − c)_i
    turning = np.einsum("ni,kij->njk", near.arms, near.turned.first)
    at_points = np.einsum("ij,njl,ml->nim", r, curved, r)
    by_turn = np.einsum("ij,njl,nlk->nik", r, curved, turning)
    own = np.einsum("njk,njl,nlm->km", turning, curved, turning)
    if not convex:
        by_turn = by_turn + np.einsum("kij,nj->nik", near.turned.first, near.forces)
        own = own + near.turned.curvatures(near.moment)
    within = np.zeros((SIX, SIX))
    within[:3, :3] = at_points.sum(axis=0)
    within[:3, 3:] = -by_turn.sum(axis=0)
    within[3:, :3] = within[:3, 3:].T
    within[3:, 3:] = own
    return at_points, np.concatenate([-at_points, by_turn], axis=2), within

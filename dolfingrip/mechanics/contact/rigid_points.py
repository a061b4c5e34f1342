"""Contact of a rigid body with another one of prescribed pose, such as food with a table."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.contact import pose_contact
from dolfingrip.mechanics.contact.density import Density
from dolfingrip.mechanics.contact.distance import MovingPoints, SignedDistance
from dolfingrip.mechanics.contact.node_set import RelativeNodes, weights
from dolfingrip.mechanics.contact.tangential import Tangential
from dolfingrip.mechanics.model.pose import SIX, Pose, rotation
from dolfingrip.mechanics.model.term import Coupling
from dolfingrip.mechanics.model.unknowns import Gradient


class RigidPoints(pose_contact.PoseContact):
    """A rigid body's own points stay outside another one of prescribed pose, which does not turn.

    Π = Σ A_j b(φ(c + R Y_j − c')) over points Y_j of the skin with their shares A_j of its area, c'
    the place of the other body, φ its signed distance. The other may move between load steps only
    so that no point comes to lie within it.

    Args:
        u: displacement (mm) of the model.
        points: (n, 3) places Y_j in the body's own axes (mm).
        areas: (n,) areas A_j (mm²).
        pose: of the body.
        shape: φ of the other body.
        other: prescribed pose of the other body.
        density: the barrier.
        copies: number of meshed parts that make the whole and share the body.
    """

    name: ClassVar[str] = "table"
    passes: ClassVar[str] = "the object passes through the table"

    def __init__(
        self,
        u: fem.Function,
        points: np.ndarray,
        areas: np.ndarray,
        pose: Pose,
        shape: SignedDistance,
        other: Pose,
        density: Density,
        copies: int = 1,
    ) -> None:
        super().__init__(shape, pose, density, copies)
        self.other = other
        self._space = u.function_space
        self._points = points
        self._areas = areas / copies

    def _places(self, turned: np.ndarray) -> np.ndarray:
        """Points in the other body's frame, for a rotation matrix of this body, (n, 3)."""
        apart = self.pose.coordinates[:3] - self.other.coordinates[:3]
        return np.asarray(self._points @ turned.T + apart)

    def gaps_mm(self, dofs: np.ndarray) -> np.ndarray:
        """Distances of the points from the other body, (n,)."""
        return self.shape.at(self._places(rotation(self.pose.coordinates[3:]).matrix)).value

    def near(self, dofs: np.ndarray) -> pose_contact.Near:
        """Points within the barrier's width of the other body."""
        turned = rotation(self.pose.coordinates[3:])
        rows, distances, barrier = self._felt(self._places(turned.matrix))
        arms, areas = self._points[rows], self._areas[rows]
        return pose_contact.Near(rows, arms, areas, turned, np.eye(3), distances, barrier)

    def _moving(self, dofs: np.ndarray, step: np.ndarray) -> MovingPoints:
        q, change = self.pose.coordinates, self.pose.change(step)
        still = np.zeros_like(self._points)
        apart = q[:3] - self.other.coordinates[:3]
        return MovingPoints(self._points, still, apart, change[:3], q[3:], change[3:], back=False)

    # -- the potential ---------------------------------------------------------------------------

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives by the pose (N)."""
        self.pose.add_slopes(pose_contact.slopes(self.near(dofs)), gradient)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Second derivatives by the pose."""
        within = pose_contact.curvatures(self.near(dofs), convex=convex)
        return self.pose.coupling(0, np.zeros((SIX, 0)), within)

    # -- for friction ----------------------------------------------------------------------------

    @cached_property
    def touching(self) -> RelativeNodes:
        """Both bodies."""
        return RelativeNodes(self._space, np.zeros(0, np.int64), None, [self.pose, self.other])

    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Points within the barrier's width, each paired with the other body's point below it."""
        near = self.near(dofs)
        pressed = np.flatnonzero(near.barrier.slope < 0)
        points = near.arms[pressed]
        below = points @ near.turned.matrix.T + self.pose.coordinates[:3]
        below = below - self.other.coordinates[:3]
        at_rows = np.concatenate([weights(points), -weights(below)], axis=1)
        return Tangential(
            sp.csr_matrix(at_rows),
            near.distances.gradient[pressed],
            -(near.areas * near.barrier.slope)[pressed],
            (near.areas * near.barrier.curvature)[pressed],
            near.rows[pressed, None],
        )

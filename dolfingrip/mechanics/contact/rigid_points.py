"""Contact of a rigid body with another of prescribed pose, such as food with a table."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.contact.advance import KEPT, Path, reach
from dolfingrip.mechanics.contact.density import BarrierValues, Density
from dolfingrip.mechanics.contact.distance import Distances, SignedDistance
from dolfingrip.mechanics.contact.relative import RelativeNodes, weights
from dolfingrip.mechanics.contact.tangential import Tangential
from dolfingrip.mechanics.model.pose import SIX, Pose
from dolfingrip.mechanics.model.rotation import Rotation, rotation
from dolfingrip.mechanics.model.term import Coupling, Term
from dolfingrip.mechanics.model.unknowns import Gradient


class _Near(NamedTuple):
    """Points that feel the other body: which, where (own axes), barrier; normals outside."""

    rows: np.ndarray
    points: np.ndarray
    turned: Rotation
    distances: Distances
    barrier: BarrierValues
    areas: np.ndarray

    @property
    def forces(self) -> np.ndarray:
        """(n, 3) derivatives by the points' places in the world (N)."""
        return (self.areas * self.barrier.slope)[:, None] * self.distances.gradient


class RigidPoints(Term):
    """A rigid body's own points stay outside another one of prescribed pose, which does not turn.

    Π = Σ A_j b(φ(c + R Y_j − c')) over points Y_j of the skin with their shares A_j of its area, c'
    the place of the other body, φ its signed distance. The other may move between load steps only
    so that no point comes to lie within it.

    Args:
        u: displacement (mm) of the model.
        points: (n, 3) Y_j in the body's own axes (mm).
        areas: (n,) A_j (mm²).
        pose: of the body.
        shape: φ of the other one.
        other: pose of that, prescribed.
        density: the barrier.
        copies: how many meshed parts make the whole; they share the body.
    """

    name: ClassVar[str] = "table"

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
        self.pose = pose
        self.other = other
        self.shape = shape
        self.density = density
        self._space = u.function_space
        self._points = points
        self._areas = areas / copies
        self._copies = copies

    def _places(self, q: np.ndarray) -> np.ndarray:
        """(n, 3) points as the other body sees them."""
        turned = rotation(q[3:]).matrix
        return np.asarray(self._points @ turned.T + q[:3] - self.other.coordinates[:3])

    def gaps_mm(self) -> np.ndarray:
        """(n,) distances of the points from the other body."""
        return self.shape.at(self._places(self.pose.coordinates)).value

    def _near(self) -> _Near:
        q = self.pose.coordinates
        every = self.shape.at(self._places(q))
        rows = np.flatnonzero(every.value < self.density.width_mm * (1 + 1e-6))
        distances = Distances(*(values[rows] for values in every))
        barrier = self.density.at(distances.value)
        turned = rotation(q[3:])
        return _Near(rows, self._points[rows], turned, distances, barrier, self._areas[rows])

    # -- the potential ---------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part's share."""
        near = self._near()
        return float(near.areas @ near.barrier.energy)

    def _slopes(self, near: _Near) -> np.ndarray:
        """(6,) derivatives by the pose."""
        moment = near.forces.T @ near.points
        return np.concatenate([near.forces.sum(axis=0), near.turned.slopes(moment)])

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives by the pose (N)."""
        self.pose.add_slopes(self._slopes(self._near()), gradient)

    def load_N(self) -> np.ndarray:
        """(3,) force on the whole body."""
        return -self._copies * self._slopes(self._near())[:3]

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Second derivatives by the pose."""
        near = self._near()
        normal = near.distances.gradient
        curved = (near.areas * near.barrier.curvature)[:, None, None] * (
            normal[:, :, None] * normal[:, None, :]
        )
        if not convex:
            curved += (near.areas * near.barrier.slope)[:, None, None] * near.distances.hessian
        moving = np.zeros((len(near.rows), 3, SIX))
        moving[:, :, :3] = np.eye(3)
        moving[:, :, 3:] = np.einsum("kij,nj->nik", near.turned.first, near.points)
        within = np.einsum("nik,nij,njl->kl", moving, curved, moving)
        if not convex:
            within[3:, 3:] += near.turned.curvatures(near.forces.T @ near.points)
        return self.pose.coupling(0, np.zeros((SIX, 0)), within)

    # -- for friction ----------------------------------------------------------------------------

    @cached_property
    def touching(self) -> RelativeNodes:
        """Both bodies."""
        return RelativeNodes(self._space, np.zeros(0, np.int64), None, [self.pose, self.other])

    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Points that feel the other body, each against that body's point below it."""
        near = self._near()
        pressed = np.flatnonzero(near.barrier.slope < 0)
        points = near.points[pressed]
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

    def facing(self, step: np.ndarray) -> np.ndarray:
        """(3,) 0: both bodies are among what :attr:`touching` moves."""
        return np.zeros(3)

    # -- bounds ----------------------------------------------------------------------------------

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction of ``step`` that leaves each point a tenth of its distance."""
        q, change = self.pose.coordinates, self.pose.change(step)
        arms = np.linalg.norm(self._points, axis=1)
        speed, turn = float(np.linalg.norm(change[:3])), float(np.linalg.norm(change[3:]))

        def at(part: float) -> Path:
            here = q + part * change
            found = self.shape.at(self._places(here))
            spin = np.einsum("k,kij->ij", change[3:], rotation(here[3:]).first)
            away = change[:3] + self._points @ spin.T
            slope = np.einsum("ni,ni->n", found.gradient, away)
            return Path(found.value, slope, turn * arms + speed, 2 * turn**2 * arms)

        return reach(at, self.shape.bounds, KEPT)

    def rejects(self, dofs: np.ndarray) -> str:
        """A state in which a point lies within the other body."""
        return "" if (self.gaps_mm() > 0).all() else "the object passes through the table"

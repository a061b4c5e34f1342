"""The base class of contacts by signed distance with a rigid body whose pose decides distances."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from dolfingrip.mechanics.contact.advance import reach
from dolfingrip.mechanics.contact.density import BarrierValues, Density
from dolfingrip.mechanics.contact.distance import Distances, SignedDistance
from dolfingrip.mechanics.contact.moving_points import MovingPoints
from dolfingrip.mechanics.contact.near import Near, slopes
from dolfingrip.mechanics.contact.policy import NEARNESS
from dolfingrip.mechanics.model.pose import Pose
from dolfingrip.mechanics.model.term import Term


class PoseContact(Term):
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
        """(n,) distances of this rank's points from the shape."""

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
        rows = np.flatnonzero(every.value < self.density.width_mm * NEARNESS.within)
        distances = Distances(*(values[rows] for values in every))
        return rows, distances, self.density.at(distances.value)

    # -- the potential ---------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part."""
        near = self.near(dofs)
        return float(self._sum(float(near.areas @ near.barrier.energy)))

    def load_N(self, dofs: np.ndarray) -> np.ndarray:
        """(6,) force (N) and moment-like derivative (N mm) on the body, of the whole."""
        return -self._copies * np.asarray(self._sum(slopes(self.near(dofs))))

    def facing(self, step: np.ndarray) -> np.ndarray:
        """(3,) zeros, because friction's pairs move with the nodes and bodies that points touch."""
        return np.zeros(3)

    # -- bounds ----------------------------------------------------------------------------------

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction of ``step`` in which each point keeps a tenth of its distance."""
        moving = self._moving(dofs, step)
        return self._least(reach(lambda part: moving.at(part, self.shape), self.shape.bounds))

    def rejects(self, dofs: np.ndarray) -> str:
        """A state in which a point lies within the shape."""
        least = self._least(float(self.gaps_mm(dofs).min(initial=np.inf)))
        return self.passes if least <= 0 else ""

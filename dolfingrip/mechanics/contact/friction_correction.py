"""Change of friction's forces along a step that changes normal forces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from dolfingrip.mechanics.contact.node_set import NodeSet
from dolfingrip.mechanics.contact.ramp import Ramp, size_of
from dolfingrip.mechanics.contact.tangential import Tangential
from dolfingrip.mechanics.model.unknowns import Gradient


class FrictionCorrection:
    """The part of the change of friction's forces F that the tangent at a displacement u lacks.

    Along a step w a pair slips by P w more, and its normal force grows as it is pressed more:

        C(w) = F(s(u + w), N(u) + N'(u) w) − F(s(u), N(u)) − H w

    H is the Hessian in the tangent, for fixed normal forces. The tangent planes are those of
    u. Normal forces are linear in w, from 0 to ``most_growth`` times their values at u. A
    point whose force grows more had nearly left, so its rate does not tell its force.

    Args:
        pairs: pairs that friction holds at u.
        nodes: nodes that the pairs move with, and rows of bodies, which are linear in w.
        slip: (m, 3) slip of the pairs at u (mm).
        coefficient: μ.
        ramp: f0.
        facing: returns, for a step, the (3,) displacement of the body that pairs touch, if no node.
        most_growth: factor by which a normal force grows at most.
    """

    def __init__(
        self,
        pairs: Tangential,
        nodes: NodeSet,
        slip: np.ndarray,
        coefficient: float,
        ramp: Ramp,
        facing: Callable[[np.ndarray], np.ndarray],
        most_growth: float,
    ) -> None:
        self._most_growth = most_growth
        self._pairs = pairs
        self._nodes = nodes
        self._slip = slip
        self._coefficient = coefficient
        self._ramp = ramp
        self._facing = facing
        limit_N = coefficient * pairs.normal_N
        self._start = self._at_pairs(slip, limit_N)
        self._hessian = pairs.spread(ramp.curvature(slip, limit_N, pairs.normals))
        self._curved, self._along = self._linear(slip, limit_N, convex=False)

    def linearise(self, step: np.ndarray, *, convex: bool) -> None:
        """Take the derivative of C at ``step``, a local array of the unknowns.

        Args:
            step: where.
            convex: of the parabola that touches f0 there and lies above it everywhere.
        """
        slip, limit_N = self._after(self._moved(step), step)
        self._curved, self._along = self._linear(slip, limit_N, convex=convex)

    def add_change(self, step: np.ndarray, gradient: Gradient) -> None:
        """Add C(step) (N)."""
        moved = self._moved(step)
        change = self._pairs.weights.T @ (self._at_pairs(*self._after(moved, step)) - self._start)
        self._nodes.add_to(gradient, change - _times(self._hessian, moved))

    def add_rate(self, step: np.ndarray, rate: Gradient) -> None:
        """Add the derivative of C along ``step``, at the place where it was taken last; first 0."""
        moved = self._moved(step)
        more = self._pairs.pressed_more_N(moved, self._facing(step))
        forces = self._pairs.weights.T @ (more[:, None] * self._along)
        self._nodes.add_to(rate, forces + _times(self._curved, moved))

    def _moved(self, step: np.ndarray) -> np.ndarray:
        return self._nodes.change(step)

    def _after(self, moved: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) slip and (m,) limits after the nodes have ``moved``."""
        more = self._pairs.pressed_more_N(moved, self._facing(step))
        most = self._most_growth * self._pairs.normal_N
        normal_N = np.clip(self._pairs.normal_N + more, 0.0, most)
        return self._slip + self._pairs.slip(moved), self._coefficient * normal_N

    def _at_pairs(self, slip: np.ndarray, limit_N: np.ndarray) -> np.ndarray:
        """(m, 3) forces."""
        return np.asarray((limit_N * self._ramp.per_slip(size_of(slip)))[:, None] * slip)

    def _linear(
        self, slip: np.ndarray, limit_N: np.ndarray, *, convex: bool
    ) -> tuple[sp.csr_matrix, np.ndarray]:
        """The derivatives by the slip, without H, and by the normal forces (m, 3)."""
        blocks = self._ramp.curvature(slip, limit_N, self._pairs.normals, convex=convex)
        most = self._most_growth * self._coefficient * self._pairs.normal_N
        pressed = self._coefficient * ((limit_N > 0) & (limit_N < most))
        return self._pairs.spread(blocks) - self._hessian, self._at_pairs(slip, pressed)


def _times(matrix: sp.csr_matrix, moved: np.ndarray) -> np.ndarray:
    """Product of a (3k, 3k) matrix with (k, 3) displacements."""
    return np.asarray(matrix @ moved.ravel()).reshape(moved.shape)

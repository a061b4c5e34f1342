"""Coulomb friction on any normal contact, with a memory of where its points stick.

The force rises with slip up to its limit, a smoothed Coulomb law. A correction tells how friction's
forces change along a step that changes normal forces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.contact.node_set import NodeSet
from dolfingrip.mechanics.contact.tangential import Tangential, Touching
from dolfingrip.mechanics.model.state import Memory
from dolfingrip.mechanics.model.term import Coupling, Lagged, Term
from dolfingrip.mechanics.model.unknowns import Gradient


@dataclass(frozen=True, slots=True)
class Ramp:
    """f0, whose derivative rises as 2t − t², t = |s|/ε, to 1 at t = 1, and stays there.

    Li et al., Incremental Potential Contact, ACM Trans. Graph. 39, 2020, eq. 13.

    Attributes:
        slip_mm: ε.
    """

    slip_mm: float

    def value(self, size: np.ndarray) -> np.ndarray:
        """f0(|s|) (mm)."""
        t = np.minimum(size / self.slip_mm, 1.0)
        return np.asarray(self.slip_mm * (t**2 - t**3 / 3) + np.maximum(size - self.slip_mm, 0.0))

    def per_slip(self, size: np.ndarray) -> np.ndarray:
        """f0'(|s|)/|s| (1/mm)."""
        within = (2 - size / self.slip_mm) / self.slip_mm
        return np.where(size < self.slip_mm, within, 1 / np.maximum(size, self.slip_mm))

    def curvature(
        self, slip: np.ndarray, limit_N: np.ndarray, normals: np.ndarray, *, convex: bool = False
    ) -> np.ndarray:
        """Second derivatives (m, 3, 3) (N/mm) of limits (m,) times f0 in planes with given normals.

        D = μN [a P + (f0'' − a) ŝ ŝᵀ] for each pair, a = f0'/|s| and f0'' = 2 (1 − |s|/ε)/ε.

        Args:
            slip: (m, 3) slip of the pairs (mm).
            limit_N: (m,) limits μN.
            normals: (m, 3) normals of the tangent planes.
            convex: whether it is μN a P, for the parabola in s that touches f0 and lies above it.
        """
        size = size_of(slip)
        per_slip = self.per_slip(size)
        plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
        blocks = per_slip[:, None, None] * plane
        if not convex:
            curvature = 2 * np.maximum(1 - size / self.slip_mm, 0.0) / self.slip_mm
            along = slip / np.maximum(size, np.finfo(float).tiny)[:, None]
            blocks += (curvature - per_slip)[:, None, None] * along[:, :, None] * along[:, None, :]
        return np.asarray(limit_N[:, None, None] * blocks)


def size_of(slip: np.ndarray) -> np.ndarray:
    """Lengths of (m, 3) vectors, (m,)."""
    return np.asarray(np.linalg.norm(slip, axis=1))


class Sliding(NamedTuple):
    """Pairs in a load step.

    Attributes:
        keys: (m, q) identity of each pair, which the contact defines.
        normal_N: (m,) normal forces.
        slid_mm: (m,) slip without its elastic part.
    """

    keys: np.ndarray
    normal_N: np.ndarray
    slid_mm: np.ndarray


SLIP_MM: Final = 0.02
"""The elastic displacement of a point that sticks is smaller. It is a numerical choice and not a
property of a material: small compared with the motion of fingers (mm), large enough for Newton's
method."""

SAME: Final = 1e-6
"""Relative change of the nodes' normal forces that counts as none: far above that in a load step in
which nothing happens but Newton's method ending elsewhere within its tolerance."""

MOST_GROWTH: Final = 10.0
"""Growth of a normal force in a load step up to which a point's memory stays. If forces grow less,
like those of fingers, it must not fade, or shorter steps would give other results."""


class Friction(Term, Lagged, Memory):
    """Coulomb friction where a normal contact presses points together.

    The incremental potential of a load step, summed over the contact's pairs:

        Π += Σ μ N f0(|s|),    s = P [x − x_n + e]

    x is a pair's relative displacement, x_n the one at the step's start, P the projection on its
    tangent plane, N its normal force, e its memory. f0' rises from 0 to 1 at |s| = ε, and stays
    there; see :class:`Ramp`. An accepted step leaves

        e ← P s min(1, ε/|s|)

    as the elastic displacement of points that stick and of points that slide. So friction is a
    spring up to ε and a slider in series with it: the return mapping of elastoplasticity (Wriggers,
    Computational Contact Mechanics, 2006, ch. 5) with a spring that gives way smoothly. A constant
    load moves nothing in any number of steps. Without the memory points would creep by a part of ε
    in each step.

    With N and P of the solution friction has no potential. So both are lagged in Π; the tangent is
    symmetric and friction's part of it convex. :meth:`update_lagged` takes them anew,
    :meth:`lag_error` tells how far they are off, and :meth:`lagged_correction` how forces change by
    the change of normal forces along a step. Newton's method asks for all three; a pair that first
    touches in a load step rubs in it.

    Memory follows the identity of a pair. A new pair takes the mean of its nodes' memories, such as
    that of a vertex which slides to the next triangle; see :mod:`.friction`.

    Args:
        contact: normal contact that presses points together.
        u: displacement (mm); its present value is the start of a load step.
        coefficient: μ.
        slip_mm: ε; default: :data:`SLIP_MM`.
        title: name of its memory in a state.
    """

    name: ClassVar[str] = "friction"

    def __init__(
        self,
        contact: Touching,
        u: fem.Function,
        coefficient: fem.Constant,
        slip_mm: float | None = None,
        title: str = "friction",
    ) -> None:
        self.contact = contact
        self.coefficient = coefficient
        self.slip_mm = SLIP_MM if slip_mm is None else slip_mm
        self._ramp = Ramp(self.slip_mm)
        self._u = u
        self._title = title
        self._nodes = contact.touching
        self._before = self._nodes.at_nodes(u.x.array)
        self._start = self._lagged = contact.tangential(u.x.array)
        self._memory = self._stuck = np.zeros((len(self._lagged.keys), 3))
        self._seen_N = self._lagged.pressing_N()  # at the start of the last step that took them
        self._anew = False

    # -- slip --------------------------------------------------------------------------------------

    def _slip(self, dofs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Elastic slip s (mm), (m, 3), of the pairs, and |s|, (m,)."""
        moved = self._nodes.at_nodes(dofs) - self._before
        slip = self._lagged.slip(moved) + self._lagged.flat(self._memory)
        return slip, size_of(slip)

    def _limit_N(self) -> np.ndarray:
        """Forces μN at which pairs slide, (m,)."""
        return float(self.coefficient.value) * self._lagged.normal_N

    def _at_nodes(self, normal_N: np.ndarray, dofs: np.ndarray) -> np.ndarray:
        """Gradient (N) at the nodes for given limits of the pairs, (k, 3)."""
        slip, size = self._slip(dofs)
        return np.asarray(
            self._lagged.weights.T @ ((normal_N * self._ramp.per_slip(size))[:, None] * slip)
        )

    # -- energy ------------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Incremental potential (mJ) of the load step, the same on all ranks."""
        return float(self._limit_N() @ self._ramp.value(self._slip(dofs)[1]))

    def forces_N(self, dofs: np.ndarray) -> np.ndarray:
        """Gradient at the contact's nodes, (k, 3): the forces that hold against friction."""
        return self._at_nodes(self._limit_N(), dofs)

    def dissipated_mJ(self, dofs: np.ndarray) -> float:
        """Work that sliding has dissipated since the step's start: Σ μ N max(|s| − ε, 0)."""
        size = self._slip(dofs)[1]
        return float(self._limit_N() @ np.maximum(size - self.slip_mm, 0.0))

    def sliding(self, dofs: np.ndarray) -> Sliding:
        """Pairs that are pressed together, and how far each has slid since the step's start."""
        size = self._slip(dofs)[1]
        return Sliding(
            self._lagged.keys, self._lagged.normal_N, np.maximum(size - self.slip_mm, 0.0)
        )

    def hessian(self, dofs: np.ndarray) -> sp.coo_matrix:
        """Second derivatives (N/mm) at the nodes for fixed N and P, (3k, 3k); convex."""
        slip = self._slip(dofs)[0]
        blocks = self._ramp.curvature(slip, self._limit_N(), self._lagged.normals)
        hessian = self._lagged.spread(blocks)
        hessian.eliminate_zeros()  # pairs without friction need no place in the tangent
        return sp.coo_matrix(hessian)

    # -- as a term ---------------------------------------------------------------------------------

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives (N) by the nodes that this rank owns."""
        self._nodes.add_to(gradient, self.forces_N(dofs))

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """The Hessian, the same whole on all ranks."""
        if not len(self._lagged.keys):
            return ()
        return self._nodes.couplings(self.hessian(dofs), self.forces_N(dofs), convex=convex)

    def lagged_correction(self, dofs: np.ndarray) -> FrictionCorrection | None:
        """How the forces change along a step from ``dofs`` by the change of normal forces."""
        if not len(self._lagged.keys):
            return None
        coefficient = float(self.coefficient.value)
        return FrictionCorrection(
            self._lagged,
            self._nodes,
            self._slip(dofs)[0],
            coefficient,
            self._ramp,
            self.contact.facing,
            MOST_GROWTH,
        )

    # -- lagged quantities -------------------------------------------------------------------------

    def update_lagged(self, dofs: np.ndarray) -> bool:
        """Take pairs, normal forces and tangent planes from the displacement ``dofs``.

        Not where normal forces are still those at the end of the last step that took them. They
        may lag by an error that Newton's method has borne, and a load that rests would move points
        by that.
        """
        now = self.contact.tangential(dofs)
        if not self._anew and _change(self._seen_N, now.pressing_N()) <= SAME:
            return False
        self._lagged, self._anew = now, True
        self._memory = transfer_history(self._start, self._stuck, now, MOST_GROWTH)
        return True

    def lag_error(self, dofs: np.ndarray) -> float:
        """Relative change of the nodes' normal forces since they were taken.

        That of their sum where all grow alike.
        """
        return _change(self._lagged.pressing_N(), self.contact.tangential(dofs).pressing_N())

    def lagged_state(self) -> tuple[Tangential, np.ndarray, bool]:
        """Pairs with normal forces, their memory, and whether they were taken in this step."""
        return self._lagged, self._memory, self._anew

    def restore_lagged(self, state: tuple[Tangential, np.ndarray, bool]) -> None:
        """Set what :meth:`lagged_state` gave."""
        self._lagged, self._memory, self._anew = state

    # -- memory ------------------------------------------------------------------------------------

    def accept(self) -> None:
        """Remember the elastic displacement of each pair, and where the next step starts."""
        slip, size = self._slip(self._u.x.array)
        self._stuck = slip * np.minimum(1.0, self.slip_mm / np.maximum(size, self.slip_mm))[:, None]
        self._memory = self._stuck
        self._start = self._lagged
        self._before = self._nodes.at_nodes(self._u.x.array)
        if self._anew:
            self._seen_N = self.contact.tangential(self._u.x.array).pressing_N()
            self._anew = False

    def values(self) -> dict[str, np.ndarray]:
        """Pairs at the step's start with their memory (mm)."""
        arrays = {**self._start.arrays(), "stuck_mm": self._stuck, "seen_N": self._seen_N}
        return {f"{self._title}.{name}": values.copy() for name, values in arrays.items()}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Start a step from the restored displacement with pairs and memory of then."""
        names = [*self._start.arrays(), "stuck_mm", "seen_N"]
        arrays = {name: values[f"{self._title}.{name}"].copy() for name in names}
        self._stuck = self._memory = arrays.pop("stuck_mm")
        self._seen_N, self._anew = arrays.pop("seen_N"), False
        self._start = self._lagged = Tangential.of_arrays(arrays, self._nodes.count)
        self._before = self._nodes.at_nodes(self._u.x.array)


def _change(before: np.ndarray, now: np.ndarray) -> float:
    """Difference of (k, 3) forces relative to the larger ones; 0 if there are none."""
    most = max(np.abs(before).sum(), np.abs(now).sum())
    return float(np.abs(now - before).sum() / most) if most > 0 else 0.0


TINY = np.finfo(float).tiny
"""A number that avoids 0/0."""


def transfer_history(
    start: Tangential, stuck: np.ndarray, now: Tangential, most_growth: float = 10.0
) -> np.ndarray:
    """Elastic displacement (mm) of the pairs ``now``, (m, 3).

    A pair keeps its memory. A new pair takes the mean of its nodes' memories; a vertex that slides
    to the next triangle makes such a pair. If the normal force grows by more than the factor
    ``most_growth``, memory fades. Such a point had nearly left, and a finger that is pressed
    on its plate again must not feel how it last slid off.

    Args:
        start: pairs at the load step's start.
        stuck: (n, 3) elastic displacements of these pairs.
        now: pairs in contact now.
        most_growth: growth of a normal force up to which a pair's memory stays.
    """
    row_of = {tuple(key): i for i, key in enumerate(start.keys.tolist())}
    before = np.array([row_of.get(tuple(key), -1) for key in now.keys.tolist()], dtype=np.int64)
    old, new = np.flatnonzero(before >= 0), np.flatnonzero(before < 0)
    memories, share = np.zeros((len(before), 3)), np.ones(len(before))
    memories[old] = stuck[before[old]]
    share[old] = start.normal_N[before[old]] / now.normal_N[old]
    if len(stuck) and len(new):
        weights = abs(now.weights[new])
        memories[new] = _of_nodes(start, stuck, now.weights[new])
        share[new] = weights @ start.pressed_N() / np.maximum(weights @ now.pressed_N(), TINY)
    return np.asarray(memories * np.minimum(most_growth * share, 1.0)[:, None])


def _of_nodes(start: Tangential, stuck: np.ndarray, weights: sp.csr_matrix) -> np.ndarray:
    """Mean memory of the nodes of new pairs, (j, 3).

    The memory of a node is the mean over its pairs, weighted by normal force and by the node's part
    in them. The sign of that part counts, so that both sides of a contact have opposite memories.
    """
    part = start.pressed_N()
    at_nodes = np.asarray(start.weights.T @ (start.normal_N[:, None] * stuck))
    at_nodes /= np.maximum(part, TINY)[:, None]
    size = abs(weights) @ (part > 0).astype(float)
    return np.asarray(weights @ at_nodes) / np.maximum(size, TINY)[:, None]


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
        """Slip (m, 3) and limits (m,) after the nodes have ``moved``."""
        more = self._pairs.pressed_more_N(moved, self._facing(step))
        most = self._most_growth * self._pairs.normal_N
        normal_N = np.clip(self._pairs.normal_N + more, 0.0, most)
        return self._slip + self._pairs.slip(moved), self._coefficient * normal_N

    def _at_pairs(self, slip: np.ndarray, limit_N: np.ndarray) -> np.ndarray:
        """Forces, (m, 3)."""
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

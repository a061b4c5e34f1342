"""A support that moves: the displacement of its nodes follows a few global unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.term import Coupling, global_coupling
from dolfingrip.mechanics.model.unknowns import NODE, GlobalUnknown, Gradient, Unknowns


class Motion(NamedTuple):
    """How a support moves with one global unknown.

    Attributes:
        unknown: that unknown.
        mode: (3, n) reference coordinates (mm) to (3, n) displacements (mm) for each unit of the
            unknown's value.
    """

    unknown: GlobalUnknown
    mode: Callable[[np.ndarray], np.ndarray]


class MovingSupport:
    """Supported displacements u_S that follow global unknowns a: u_S = Σ a_j W_j.

    Π is one of the free displacements u_F and of a. Its slope by a is Wᵀ r_S, r_S being the
    gradient by the supported displacements, and its second derivatives are K_FS W and
    Wᵀ K_SS W. The supported displacements stay in the vector of unknowns, so that a vector of
    them has the whole displacement: their equations are those of ½ |u_S − W a|² · 1 N/mm, which
    is 0 at every solution and after each of Newton's steps, since it is linear. It is no penalty:
    its size changes nothing.

    Args:
        u: displacement (mm).
        supports: conditions that hold the nodes, along all axes that ``motions`` move them.
        nodes: local displacement nodes of the support, ghosts included.
        motions: of the support, at least one.

    Attributes:
        global_unknowns: those of the motions.
        dofs: this rank's owned displacement dofs that move.
    """

    def __init__(
        self,
        u: fem.Function,
        supports: Sequence[fem.DirichletBC],
        nodes: np.ndarray,
        motions: Sequence[Motion],
    ) -> None:
        space = u.function_space
        index_map = space.dofmap.index_map
        self._comm = space.mesh.comm
        self._first = index_map.local_range[0]
        self._owned_nodes = index_map.size_local
        self.global_unknowns = [motion.unknown for motion in motions]
        self.dofs: np.ndarray = np.empty(0, dtype=np.int64)
        self._u, self._nodes, self._motions = u, nodes, motions
        held = np.zeros(len(u.x.array), dtype=bool)
        for bc in supports:
            held[bc.dof_indices()[0]] = True
        self._functions = [fem.Function(space) for _ in motions]
        self.dofs = np.flatnonzero(self.measure().any(axis=0))
        assert held[self._moved].all(), "a support moves along an axis that it does not hold"
        self.measure()

    def measure(self) -> np.ndarray:
        """Take the motions of the nodes where they now are at rest.

        Returns:
            (m, n) motions of this rank's owned displacements.
        """
        points = self._u.function_space.tabulate_dof_coordinates()[self._nodes].T
        for function, motion in zip(self._functions, self._motions, strict=True):
            function.x.array.reshape(-1, NODE)[self._nodes] = motion.mode(points).T
        self._moved = np.any([function.x.array != 0 for function in self._functions], axis=0)
        owned = np.array([f.x.array[: NODE * self._owned_nodes] for f in self._functions])
        self._ways = owned[:, self.dofs]
        parts = self._comm.allgather((self.dofs + NODE * self._first, self._ways))
        self._all_dofs = np.concatenate([dofs for dofs, _ in parts])
        self._all_ways = np.concatenate([ways for _, ways in parts], axis=1)
        return owned

    def place(self) -> None:
        """Set u_S = W a at all local nodes."""
        placed = sum(
            motion.unknown.value * function.x.array
            for motion, function in zip(self._motions, self._functions, strict=True)
        )
        self._u.x.array[self._moved] = placed[self._moved]

    def apart(self, dofs: np.ndarray) -> np.ndarray:
        """u_S − W a (mm) at the owned dofs that move."""
        values = np.array([unknown.value for unknown in self.global_unknowns])
        return np.asarray(dofs[self.dofs] - values @ self._ways)

    def follow(self, dofs: np.ndarray, reactions: np.ndarray, gradient: Gradient) -> None:
        """Add the slopes by the global unknowns and the equations of the moving displacements.

        Args:
            dofs: displacement.
            reactions: derivatives by all owned unknowns, supported ones included.
            gradient: where the rows of supported displacements are 0.
        """
        apart = self.apart(dofs)
        local = self._ways @ (reactions[self.dofs] - apart)
        for unknown, slope in zip(
            self.global_unknowns, self._comm.allreduce(local, MPI.SUM), strict=True
        ):
            gradient.add(unknown, float(slope))
        gradient.array[self.dofs] += apart

    # -- second derivatives ----------------------------------------------------------------------

    def tie(self) -> Coupling:
        """Second derivatives of ½ |u_S − W a|²; the diagonal's 1 N/mm is that of supports."""
        mixed = np.zeros((len(self.global_unknowns), NODE * self._owned_nodes))
        mixed[:, self.dofs] = -self._ways
        within = self._comm.allreduce(self._ways @ self._ways.T, MPI.SUM)
        return global_coupling(self.global_unknowns, self._first, mixed, within)

    def stiffness(self, potential: Potential) -> list[list[np.ndarray]]:
        """K W_j of the potential for each unknown's value, by field; owned rows."""
        return [potential.stiffness_along(function) for function in self._functions]

    def coupling(
        self, unknowns: Unknowns, along: Sequence[np.ndarray], others: Sequence[Coupling]
    ) -> Coupling:
        """Second derivatives by the global unknowns and by what does not move.

        Args:
            unknowns: of the model.
            along: K W_j of the potential by the owned displacements.
            others: of the other terms.
        """
        width = NODE * self._owned_nodes
        mixed = np.array([values[:width] for values in along])
        global_unknowns = list(unknowns.global_unknowns)
        within = np.zeros((unknowns.padded, unknowns.padded))
        rows = [self._row(unknowns, unknown) for unknown in self.global_unknowns]
        within[np.ix_(rows, rows)] = self._ways @ mixed[:, self.dofs].T
        for other in others:
            more, square = self._transformed(unknowns, other, rows)
            mixed += more
            within += square
        within = self._comm.allreduce(within, MPI.SUM)
        whole = np.zeros((len(global_unknowns), width))
        whole[rows] = mixed
        count = len(global_unknowns)
        return global_coupling(global_unknowns, self._first, whole, within[:count, :count])

    def _row(self, unknowns: Unknowns, unknown: GlobalUnknown) -> int:
        return NODE * (unknown.node - unknowns.nodes) + unknown.component

    def _transformed(
        self, unknowns: Unknowns, other: Coupling, rows: Sequence[int]
    ) -> tuple[np.ndarray, np.ndarray]:
        """H_FS W and this rank's share of the unknowns' own part, of a coupling's H.

        By values: those of :func:`global_coupling`, which multiplies by scales.
        """
        start, width = NODE * self._first, NODE * self._owned_nodes
        numbers_start = NODE * unknowns.nodes
        places = (NODE * other.nodes[:, None] + np.arange(NODE)).ravel()
        hessian = sp.coo_matrix(other.hessian)
        row, column = places[hessian.row], places[hessian.col]
        mine = (row >= start) & (row < start + width)
        if unknowns.owns_globals:
            mine |= row >= numbers_start
        row, column, data = row[mine], column[mine], hessian.data[mine]
        size = numbers_start + unknowns.padded
        # the columns (and rows) of moving displacements lead to global unknowns
        count = len(self.global_unknowns)
        to_motion = sp.csr_matrix(
            (
                self._all_ways.ravel(),
                (np.tile(self._all_dofs, count), np.repeat(np.arange(count), len(self._all_dofs))),
            ),
            shape=(size, count),
        )
        scales = np.ones(unknowns.padded)
        scales[: len(unknowns.global_unknowns)] = [
            unknown.scale for unknown in unknowns.global_unknowns
        ]
        whole = sp.csr_matrix((data, (row, column)), shape=(size, size))
        right = (whole @ to_motion).toarray()  # H W by all this rank's rows
        mixed = right[start : start + width].T.copy()
        square = np.zeros((unknowns.padded, unknowns.padded))
        square[np.ix_(rows, rows)] = to_motion.T @ right
        # of moving displacements with other unknowns, which have them in the upper triangle
        across = (to_motion.T @ whole)[:, numbers_start:].toarray() / scales
        square[rows, :] += across
        square[:, rows] += across.T
        return mixed, square

"""Displacement nodes whose values all ranks know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.model.placement import to_reference, to_world
from dolfingrip.mechanics.model.term import Coupling
from dolfingrip.mechanics.model.unknowns import NODE, Gradient


class NodeSet:
    """Some displacement nodes, whose values every rank has.

    Forces between nodes of different ranks are therefore computed alike on each rank. A rank
    contributes the rows of the nodes that it owns.

    Args:
        space: of the displacement.
        nodes: (n,) global nodes (block index), the same on all ranks.

    Attributes:
        nodes: the nodes.
        owned: places in ``nodes`` of the nodes that this rank owns.
        frames: (n, 3, 3) from reference axes to the world's; None if they are equal.
    """

    def __init__(self, space: fem.FunctionSpace, nodes: np.ndarray) -> None:
        self.frames: np.ndarray | None = None
        self._comm = space.mesh.comm
        self._first, self._end = space.dofmap.index_map.local_range
        self._number(nodes)

    def _number(self, nodes: np.ndarray) -> None:
        """Make global displacement nodes the nodes of the set."""
        self.nodes = nodes
        self.owned = np.flatnonzero((nodes >= self._first) & (nodes < self._end))
        self._owned_local = (nodes[self.owned] - self._first).astype(np.int32)

    @property
    def count(self) -> int:
        """Number of rows of :meth:`at_nodes`."""
        return len(self.nodes)

    def at_nodes(self, local_values: np.ndarray) -> np.ndarray:
        """(n, 3) values in the world at the nodes from a local array of three at each."""
        whole = np.zeros((len(self.nodes), 3))
        owned = local_values.reshape(-1, 3)[self._owned_local]
        for places, values in self._comm.allgather((self.owned, owned)):
            whole[places] = values
        return to_world(self.frames, whole)

    def change(self, step: np.ndarray) -> np.ndarray:
        """(n, 3) change of the rows of :meth:`at_nodes`, made linear, by a step of the unknowns."""
        return NodeSet.at_nodes(self, step[: NODE * (self._end - self._first)])

    def add_owned(self, values: np.ndarray, target: np.ndarray) -> None:
        """Add the owned rows of (n, 3) values at the nodes to this rank's nodal values (m, 3)."""
        target[self._owned_local] += to_reference(self.frames, values)[self.owned]

    # -- for terms whose forces act on the rows of at_nodes ----------------------------------------

    def add_to(self, gradient: Gradient, forces_N: np.ndarray) -> None:
        """Add (n, 3) derivatives by the rows of :meth:`at_nodes`."""
        self.add_owned(forces_N, gradient.at_nodes)

    def couplings(
        self, hessian: sp.coo_matrix, forces_N: np.ndarray, *, convex: bool
    ) -> Sequence[Coupling]:
        """Second derivatives by the unknowns.

        Args:
            hessian: (3n, 3n) by the rows of :meth:`at_nodes`.
            forces_N: (n, 3) first derivatives, which matter if rows are not linear functions.
            convex: without the parts that make them indefinite.
        """
        return [Coupling(self.nodes, self.in_reference(hessian))]

    def in_reference(self, hessian: sp.coo_matrix) -> sp.coo_matrix:
        """A (3n, 3n) matrix for world axes, converted to reference axes."""
        if self.frames is None:
            return hessian
        places = np.arange(len(self.nodes) + 1)
        shape = (3 * len(self.nodes),) * 2
        turn = sp.bsr_matrix((self.frames, places[:-1], places), shape)
        return sp.coo_matrix(turn.T @ hessian @ turn)

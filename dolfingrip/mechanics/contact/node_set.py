"""Displacement nodes that all ranks know the values of."""

from __future__ import annotations

import numpy as np
from dolfinx import fem


class NodeSet:
    """Some displacement nodes, and their values whole on every rank.

    What acts between nodes of different ranks is so found alike on each; a rank contributes the
    rows of the nodes it owns.

    Args:
        space: of the displacement.
        nodes: (n,) global nodes (block index), the same on all ranks.

    Attributes:
        nodes: as given.
        owned: places in ``nodes`` of those this rank owns.
    """

    def __init__(self, space: fem.FunctionSpace, nodes: np.ndarray) -> None:
        self._comm = space.mesh.comm
        self._first, self._end = space.dofmap.index_map.local_range
        self._number(nodes)

    def _number(self, nodes: np.ndarray) -> None:
        """Take global displacement nodes as those of the set."""
        self.nodes = nodes
        self.owned = np.flatnonzero((nodes >= self._first) & (nodes < self._end))
        self._owned_local = (nodes[self.owned] - self._first).astype(np.int32)

    def at_nodes(self, local_values: np.ndarray) -> np.ndarray:
        """(n, 3) values at the nodes from a local array of three at each."""
        whole = np.zeros((len(self.nodes), 3))
        owned = local_values.reshape(-1, 3)[self._owned_local]
        for places, values in self._comm.allgather((self.owned, owned)):
            whole[places] = values
        return whole

    def add_owned(self, values: np.ndarray, target: np.ndarray) -> None:
        """Add those of (n, 3) values at the nodes that this rank owns to its nodes' (m, 3)."""
        target[self._owned_local] += values[self.owned]

"""Deformable surfaces as linear triangles, known whole on every rank."""

from __future__ import annotations

from copy import copy

import numpy as np
from dolfinx import fem

from dolfingrip.mechanics.domain import Domain

# A quadratic facet's nodes are its corners, then the midpoints opposite to them.
SPLIT = {
    3: np.array([[0, 1, 2]]),
    6: np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]]),
}


class Surface:
    """Triangulated surface of a body, its vertices being displacement nodes.

    Each quadratic facet becomes four triangles. All ranks hold the same arrays, so that contact
    is found alike on each; a rank contributes the rows of the nodes it owns.

    Attributes:
        rest: (n, 3) reference positions (mm).
        triangles: (m, 3) vertex numbers.
        nodes: (n,) global displacement nodes (block index) of the vertices.
        owned: vertex numbers of the nodes this rank owns.
    """

    def __init__(self, space: fem.FunctionSpace, domain: Domain, facets: np.ndarray) -> None:
        self._comm = space.mesh.comm
        index_map = space.dofmap.index_map
        local = _facet_nodes(space, domain, facets)
        global_nodes = index_map.local_to_global(local.ravel().astype(np.int32))
        gathered = self._comm.allgather(global_nodes.reshape(local.shape))
        width = max(block.shape[1] for block in gathered)
        faces = np.concatenate([b.reshape(-1, width) for b in gathered])
        nodes, renumbered = np.unique(faces, return_inverse=True)
        first = index_map.local_range[0]
        mine = (nodes >= first) & (nodes < index_map.local_range[1])
        self.nodes, self.owned = nodes, np.flatnonzero(mine)
        self._owned_local = (nodes[mine] - first).astype(np.int32)
        rest = self._gather(space.tabulate_dof_coordinates()[self._owned_local])
        # ipctk's collision sets depend on the order of vertices and triangles, which must not
        # depend on the ranks': sort by position, not by owner
        order = _by_position(rest)
        rank_of = np.empty_like(order)
        rank_of[order] = np.arange(len(order))
        self.nodes, self.rest = nodes[order], rest[order]
        self.owned = rank_of[self.owned]
        renumbered = _canonical(rank_of[renumbered].reshape(faces.shape))
        self.triangles = renumbered[:, SPLIT[width]].reshape(-1, 3).astype(np.int32)

    def _gather(self, owned_values: np.ndarray) -> np.ndarray:
        """(n, 3) values at all vertices from each rank's owned ones."""
        whole = np.zeros((len(self.nodes), 3))
        parts = self._comm.allgather((self.owned, owned_values))
        for vertices, values in parts:
            whole[vertices] = values
        return whole

    def moved(self, change_mm: np.ndarray) -> Surface:
        """The same surface at other reference positions; ``change_mm`` is (n, 3)."""
        other = copy(self)
        other.rest = np.asfortranarray(self.rest + change_mm)
        return other

    def displacement(self, local_dofs: np.ndarray) -> np.ndarray:
        """(n, 3) displacement (mm) of the vertices from a local dof array."""
        return self._gather(local_dofs.reshape(-1, 3)[self._owned_local])

    def positions(self, local_dofs: np.ndarray) -> np.ndarray:
        """(n, 3) deformed positions (mm), in the column order that ipctk wants."""
        return np.asfortranarray(self.rest + self.displacement(local_dofs))

    @property
    def edges(self) -> np.ndarray:
        """(k, 2) unique edges of the triangles."""
        pairs = np.concatenate(
            [self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]]
        )
        return np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int32)


def _by_position(points: np.ndarray) -> np.ndarray:
    """(n,) order of points by z, y, x, blind to rounding."""
    # an irrational shift keeps round positions off the borders between two roundings
    keys = np.floor(points / (1e-7 * np.ptp(points, axis=0).max()) + 0.2360679775)
    return np.lexsort(keys.T)


def _canonical(facets: np.ndarray) -> np.ndarray:
    """Facets with their corners in ascending order, their midpoints likewise, and sorted."""
    turn = np.argsort(facets[:, :3], axis=1)
    parts = [
        np.take_along_axis(facets[:, i : i + 3], turn, axis=1) for i in range(0, facets.shape[1], 3)
    ]
    facets = np.concatenate(parts, axis=1)
    return facets[np.lexsort(facets[:, 2::-1].T)]


def _facet_nodes(space: fem.FunctionSpace, domain: Domain, facets: np.ndarray) -> np.ndarray:
    """(n, 3 | 6) local displacement nodes of each facet: corners, then midpoints."""
    topology = domain.mesh.topology
    to_cell = topology.connectivity(2, 3)
    topology.create_connectivity(3, 2)
    to_facet = topology.connectivity(3, 2)
    closure = [np.array(dofs) for dofs in space.element.basix_element.entity_closure_dofs[2]]
    nodes = np.empty((len(facets), len(closure[0])), dtype=np.int32)
    for row, facet in enumerate(facets):
        cell = to_cell.links(facet)[0]
        which = int(np.flatnonzero(to_facet.links(cell) == facet)[0])
        nodes[row] = space.dofmap.cell_dofs(cell)[closure[which]]
    return nodes

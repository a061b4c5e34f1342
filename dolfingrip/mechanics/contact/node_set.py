"""Displacement nodes whose values all ranks know, and the slip of pairs in contact.

Pairs slide by the motions of a surface's nodes and of points of rigid bodies.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.model.placement import to_reference, to_world
from dolfingrip.mechanics.model.pose import SIX, Pose, Rotation, rotation
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
        """Values in the world at the nodes from a local array of three at each, (n, 3)."""
        gathered = np.zeros((len(self.nodes), 3))
        owned = local_values.reshape(-1, 3)[self._owned_local]
        for places, values in self._comm.allgather((self.owned, owned)):
            gathered[places] = values
        return to_world(self.frames, gathered)

    def change(self, step: np.ndarray) -> np.ndarray:
        """Change (n, 3) of the rows of :meth:`at_nodes`, made linear, by a step of the unknowns."""
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


AFFINE = 4
"""Rows by which a rigid body's points move: its centre, and its three axes."""


class RelativeNodes(NodeSet):
    """Displacement nodes, and after them four rows for each rigid body: c, R e₁, R e₂ and R e₃.

    A body's point Y is at c + Σ Y_k R e_k, a linear function of its rows, with the weights that
    :func:`weights` gives. So the slip of a pair between a node and a body, or between two bodies,
    is a linear function of rows, like that of a pair of nodes. Derivatives by the rotation vector
    are those of R : M.

    Args:
        space: of the displacement.
        nodes: (n,) global nodes, the same on all ranks.
        frames: (n, 3, 3) from reference axes to the world's; None where they are the same.
        poses: poses of the bodies; at most one may be solved for.
    """

    def __init__(
        self,
        space: fem.FunctionSpace,
        nodes: np.ndarray,
        frames: np.ndarray | None,
        poses: Sequence[Pose],
    ) -> None:
        super().__init__(space, nodes)
        self.frames = frames
        self.poses = tuple(poses)
        self._owned_nodes = space.dofmap.index_map.size_local

    @property
    def count(self) -> int:
        """Number of rows of :meth:`at_nodes`."""
        return len(self.nodes) + AFFINE * len(self.poses)

    def at_nodes(self, local_values: np.ndarray) -> np.ndarray:
        """Displacements (mm) of the nodes, followed by the present rows of the bodies (mm; 1)."""
        rows = [super().at_nodes(local_values)]
        for pose in self.poses:
            q = pose.coordinates
            rows += [q[None, :3], rotation(q[3:]).matrix.T]
        return np.concatenate(rows)

    def change(self, step: np.ndarray) -> np.ndarray:
        """Change (n, 3) of the rows of :meth:`at_nodes`, made linear, by a step of the unknowns.

        A body whose pose is prescribed does not move.
        """
        rows = [super().change(step)]
        for pose in self.poses:
            moving = _motion(rotation(pose.coordinates[3:]))
            rows.append((moving @ pose.change(step)).reshape(AFFINE, NODE))
        return np.concatenate(rows)

    def _of(self, body: int) -> slice:
        """Rows of a body."""
        start = len(self.nodes) + AFFINE * body
        return slice(start, start + AFFINE)

    def add_to(self, gradient: Gradient, forces_N: np.ndarray) -> None:
        """Add (n, 3) derivatives by the rows of :meth:`at_nodes`."""
        self.add_owned(forces_N[: len(self.nodes)], gradient.at_nodes)
        for body, pose in enumerate(self.poses):
            if pose.free:
                by_rows = forces_N[self._of(body)]
                turned = rotation(pose.coordinates[3:])
                slopes = np.concatenate([by_rows[0], turned.slopes(by_rows[1:].T)])
                pose.add_slopes(slopes, gradient)

    def couplings(
        self, hessian: sp.coo_matrix, forces_N: np.ndarray, *, convex: bool
    ) -> Sequence[Coupling]:
        """Second derivatives by the unknowns, as in :class:`~.node_set.NodeSet`."""
        csr = sp.csr_matrix(hessian)
        count = NODE * len(self.nodes)
        couplings = []
        if count:
            couplings.append(Coupling(self.nodes, self.in_reference(csr[:count, :count].tocoo())))
        for body, pose in enumerate(self.poses):
            if pose.free:
                rows = self._of(body)
                dofs = slice(NODE * rows.start, NODE * rows.stop)
                turned = rotation(pose.coordinates[3:])
                moving = _motion(turned)
                within = moving.T @ csr[dofs, dofs].toarray() @ moving
                if not convex:
                    within[3:, 3:] += turned.curvatures(forces_N[rows][1:].T)
                across = moving.T @ csr[dofs, :count].toarray()
                couplings += pose.coupling(self._first, self._owned_columns(across), within)
        return couplings

    def _owned_columns(self, across: np.ndarray) -> np.ndarray:
        """In reference axes from (6, 3n) by the nodes' values in the world, (6, 3 owned)."""
        at_nodes = across.reshape(SIX, -1, NODE)
        mixed = np.zeros((SIX, self._owned_nodes, NODE))
        for k in range(SIX):
            self.add_owned(at_nodes[k], mixed[k])
        return mixed.reshape(SIX, -1)


def _motion(turned: Rotation) -> np.ndarray:
    """Derivatives of a body's four rows by its centre and rotation vector, (12, 6)."""
    derivatives = np.zeros((NODE * AFFINE, SIX))
    derivatives[:3, :3] = np.eye(3)
    # ∂(R e_j)_i/∂θ_k in row 3 (1 + j) + i
    derivatives[3:, 3:] = turned.first.transpose(2, 1, 0).reshape(-1, 3)
    return derivatives


def weights(points: np.ndarray) -> np.ndarray:
    """Weights of a body's rows in the places of (m, 3) points in its own axes, (m, 4)."""
    return np.concatenate([np.ones((len(points), 1)), points], axis=1)

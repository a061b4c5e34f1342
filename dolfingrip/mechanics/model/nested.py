"""A model on the bisected mesh, to first order about a solution on the mesh itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import basix
import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from dolfinx import mesh as dolfinx_mesh
from dolfinx.io.utils import cell_perm_gmsh

from dolfingrip.mechanics.model import linearised
from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.mechanics.model.element import displacement_element
from dolfingrip.mechanics.model.linearised import Expansion, Linearised
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.term import Coupling, Term
from dolfingrip.mechanics.model.unknowns import NODE, Gradient
from dolfingrip.meshes.bisection import PARTS, corners_of_parts, linear
from dolfingrip.meshes.cells import CellShape

ROUNDING: Final = 1e-12
"""Below it a shape function is 0."""


class Nesting:
    """What the cells of a mesh and their parts have to do with one another, on one rank.

    Args:
        shape: of the cells.
        element: name of the displacement element.
        coarse, fine: displacements on the mesh, and on that of the parts.

    Attributes:
        prolongation: (fine nodes, nodes) values of a displacement at the nodes of the parts.
        same: (nodes,) node of the parts at the place of each node.
    """

    def __init__(
        self, shape: CellShape, element: str, coarse: fem.Function, fine: fem.Function
    ) -> None:
        # DOLFINx has corners in another order, and the reference element with them
        order = cell_perm_gmsh(dolfinx_mesh.to_type(shape.name), shape.corners)
        self._shape, self._order = shape, order
        self._corners = corners_of_parts(shape)[:, order]
        first, second = (
            each.function_space.mesh.topology.original_cell_index for each in (coarse, fine)
        )
        self._parent, self._part = np.argsort(first)[second // PARTS], second % PARTS
        own = displacement_element(element, ()).basix_element
        basis = np.stack([own.tabulate(0, self._placed(own.points, part))[0, :, :, 0]
                          for part in range(PARTS)])  # fmt: skip
        basis[np.abs(basis) < ROUNDING] = 0.0
        dofs, fine_dofs = (each.function_space.dofmap for each in (coarse, fine))
        values = basis[self._part]
        rows = np.broadcast_to(fine_dofs.list[:, :, None], values.shape)
        columns = np.broadcast_to(dofs.list[self._parent][:, None, :], values.shape)
        size = fine_dofs.index_map.size_local, dofs.index_map.size_local
        # parts that share a node have the same row: one of them is kept
        _, once = np.unique(fine_dofs.list, return_index=True)
        kept = np.zeros(fine_dofs.list.size, dtype=bool)
        kept[once] = True
        places = kept.reshape(fine_dofs.list.shape)[:, :, None] & (values != 0)
        self.prolongation = sp.csr_matrix(
            (values[places], (rows[places], columns[places])), shape=size
        )
        alone = np.flatnonzero(np.diff(self.prolongation.indptr) == 1)
        self.same = np.empty(size[1], dtype=np.int64)
        self.same[self.prolongation.indices[self.prolongation.indptr[alone]]] = alone

    def _linear(self, places: np.ndarray) -> np.ndarray:
        """Linear shape functions, in DOLFINx' order of the corners."""
        return linear(self._shape, places)[:, self._order]

    def _placed(self, places: np.ndarray, part: int) -> np.ndarray:
        """Places in a cell of places in one of its parts."""
        return np.asarray(self._linear(places) @ self._corners[part])

    def to_parts(self, values: np.ndarray, degree: int) -> np.ndarray:
        """Continue values at a cell's integration points to those of its parts.

        Those of a cell are fitted by linear shape functions, as the stress at the points of a
        reduced rule is more exact than at others.

        Args:
            values: (cells, points, entries).
            degree: of the rule.

        Returns:
            (parts, points, entries).
        """
        kind = getattr(basix.CellType, self._shape.name)
        places = basix.make_quadrature(kind, degree)[0]
        fit = np.linalg.pinv(self._linear(places))
        by_part = np.stack(
            [self._linear(self._placed(places, part)) @ fit for part in range(PARTS)]
        )
        found = np.empty((len(self._parent), *values.shape[1:]))
        for part in range(PARTS):
            mine = self._part == part
            found[mine] = by_part[part] @ values[self._parent[mine]]
        return found


class Unrefined(Term):
    """The terms of a model that elements do not integrate, as its own nodes feel them.

    They are linear in the change of the displacement from the model's state.

    Args:
        model: at a solution.
        same: node of the parts at the place of each node.
    """

    def __init__(self, model: Model, same: np.ndarray) -> None:
        self._model, self._same = model, same
        self._force = np.empty(0)
        self._couplings: list[Coupling] = []

    def take(self, start: np.ndarray) -> None:
        """Take forces and stiffness at the model's present state; ``start`` is that of the parts."""
        model, self._start = self._model, start.copy()
        gradient, dofs = Gradient(model.unknowns), model.u.x.array
        for term in model.terms:
            term.add_gradient(dofs, gradient)
        self._force = gradient.at_nodes.copy()
        self._couplings = [
            Coupling(self._same[nodes], hessian)
            for term in model.terms
            for nodes, hessian in term.couplings(dofs)
        ]

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the forces at a displacement of the parts."""
        gradient.at_nodes[self._same] += self._force
        change = (dofs - self._start).reshape(-1, NODE)
        for nodes, hessian in self._couplings:
            np.add.at(
                gradient.at_nodes, nodes, (hessian @ change[nodes].ravel()).reshape(-1, NODE)
            )

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Return the stiffness at the model's state."""
        return self._couplings

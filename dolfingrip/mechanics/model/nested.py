"""Fields of a mesh on its bisection."""

from __future__ import annotations

from typing import Final

import basix
import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from dolfinx import mesh as dolfinx_mesh
from dolfinx.io.utils import cell_perm_gmsh

from dolfingrip.mechanics.model.element import displacement_element
from dolfingrip.meshes.bisection import PARTS, corner_weights, corners_of_parts
from dolfingrip.meshes.cells import CellShape

ROUNDING: Final = 1e-12
"""Below it a shape function is 0."""


class Nesting:
    """Maps from fields of a mesh to fields of its bisection, on one rank.

    Args:
        shape: of the cells.
        element: name of the displacement element.
        coarse, fine: displacements on the mesh, and on that of the parts.

    Attributes:
        prolongation: (fine nodes, nodes) values of a displacement at the nodes of the parts.
    """

    def __init__(
        self, shape: CellShape, element: str, coarse: fem.Function, fine: fem.Function
    ) -> None:
        # DOLFINx has corners in another order, and the reference element with them
        order = cell_perm_gmsh(dolfinx_mesh.to_type(shape.name), shape.corners)
        self._shape, self._order = shape, order
        self._kind = getattr(basix.CellType, shape.name)
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
        entries = values[places], (rows[places], columns[places])
        self.prolongation = sp.csr_matrix(entries, shape=size)

    def _linear(self, places: np.ndarray) -> np.ndarray:
        """Linear shape functions, in DOLFINx' order of the corners."""
        return corner_weights(self._shape, places)[:, self._order]

    def _placed(self, places: np.ndarray, part: int) -> np.ndarray:
        """Places in a cell of places in one of its parts."""
        return np.asarray(self._linear(places) @ self._corners[part])

    def nearest(self, values: np.ndarray, degree: int) -> np.ndarray:
        """Give the integration points of the parts the values of the nearest one of their cell.

        Args:
            values: (cells, points, entries).
            degree: of the rule.

        Returns:
            (parts, points, entries).
        """
        places, own = self._places(degree)
        which = np.linalg.norm(own[:, :, None] - places, axis=3).argmin(axis=2)
        return np.asarray(values[self._parent[:, None], which[self._part]])

    def continued(self, values: np.ndarray, degree: int) -> np.ndarray:
        """Continue values at a cell's integration points to those of its parts linearly.

        Args:
            values: (cells, points, entries).
            degree: of the rule.

        Returns:
            (parts, points, entries).
        """
        places, own = self._places(degree)
        fit = np.linalg.pinv(self._linear(places))
        weights = np.stack([self._linear(each) @ fit for each in own])
        return np.asarray(weights[self._part] @ values[self._parent])

    def _places(self, degree: int) -> tuple[np.ndarray, np.ndarray]:
        """Integration points in a cell, (points, 3), and those of its parts, (parts, points, 3)."""
        places = np.asarray(basix.make_quadrature(self._kind, degree)[0])
        return places, np.stack([self._placed(places, part) for part in range(PARTS)])

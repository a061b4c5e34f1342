"""Derivatives of a number by all coordinates of the reference mesh, as one vector."""

from __future__ import annotations

from functools import cached_property
from typing import Final

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem, la
from mpi4py import MPI

from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.compatibility import points_of_cells

BY_COORDINATES: Final = "dolfingrip: by coordinates"
"""Place of a form's compiled derivatives in what UFL lets others keep with the form."""


class Coordinates:
    """The coordinates of a mesh as degrees of freedom.

    Args:
        space: of the displacement, whose nodes have places that follow from the mesh's points.

    Attributes:
        space: of the mesh's own coordinate element; a value of it moves the mesh's points.
        displacement: the argument.
        local: number of the mesh's points that this rank knows.
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        self.displacement = space
        self.mesh = mesh = space.mesh
        self.comm: MPI.Comm = mesh.comm
        self.space = fem.functionspace(mesh, mesh.ufl_domain().ufl_coordinate_element())
        dofs = self.space.dofmap
        self._owned = dofs.index_map.size_local
        self.local = self._owned + dofs.index_map.num_ghosts
        # the number in the space of each point of the geometry
        self._number = np.empty(len(mesh.geometry.x), dtype=np.int64)
        self._number[points_of_cells(mesh.geometry)] = dofs.list

    @property
    def test(self) -> ufl.Argument:
        """The test function by which a form's derivative is a vector."""
        return ufl.TestFunction(self.space)

    def compiled(self, form: ufl.Form) -> fem.Form:
        """The derivative of a form by the coordinates, at fixed nodal values of all fields."""
        x = ufl.SpatialCoordinate(self.mesh)
        return to_assemble(ufl.derivative(form, x, self.test))

    @cached_property
    def of_nodes(self) -> sp.csr_matrix:
        """Where a node is between the points, (local nodes of the displacement, local points)."""
        element = self.displacement.element.basix_element
        shapes = self.space.element.basix_element.tabulate(0, element.points)[0, :, :, 0]
        nodes, points = self.displacement.dofmap.list, self.space.dofmap.list
        count = self.displacement.dofmap.index_map
        rows = np.repeat(nodes, points.shape[1], axis=1).ravel()
        columns = np.tile(points, (1, nodes.shape[1])).ravel()
        values = np.tile(shapes.ravel(), len(nodes))
        _, first = np.unique(rows * np.int64(self.local) + columns, return_index=True)
        kept = first[np.abs(values[first]) > 1e-12]
        shape = (count.size_local + count.num_ghosts, self.local)
        return sp.csr_matrix((values[kept], (rows[kept], columns[kept])), shape=shape)

    def owned_part(self, velocity: np.ndarray) -> np.ndarray:
        """Rows of the points that this rank owns, from (m, 3) of all its local points, (k, 3)."""
        field = np.zeros((self.local, 3))
        field[self._number] = velocity
        return field[: self._owned]

    def summed(self, local: np.ndarray) -> np.ndarray:
        """Owned rows of the sum of all ranks' parts, each (local points, 3), (k, 3)."""
        vector = la.vector(self.space.dofmap.index_map, 3)
        vector.array[:] = local.ravel()
        vector.scatter_reverse(la.InsertMode.add)
        return vector.array[: 3 * self._owned].reshape(-1, 3).copy()


class ShapeGradient:
    """Derivatives by the reference coordinates, which terms and readings add to.

    Nodal displacements, pressures and global unknowns stay while the mesh's points move.

    Args:
        coordinates: of the mesh.

    Attributes:
        coordinates: as given.
        at_nodes: (n, 3) derivatives by the rest places of the displacement's local nodes, for each
            mm. A rank adds only to nodes that it owns.
    """

    def __init__(self, coordinates: Coordinates) -> None:
        self.coordinates = coordinates
        index = coordinates.displacement.dofmap.index_map
        self.at_nodes = np.zeros((index.size_local + index.num_ghosts, 3))
        self._by_points = np.zeros((coordinates.local, 3))

    def add_form(self, form: ufl.Form, factor: float = 1.0) -> None:
        """Add the derivatives of a form, which are compiled when they are first asked for.

        Args:
            form: without arguments.
            factor: of its derivatives.
        """
        if BY_COORDINATES not in form._cache:
            form._cache[BY_COORDINATES] = self.coordinates.compiled(form)
        # this rank's part, ghosts included
        vector = fem.assemble_vector(form._cache[BY_COORDINATES])
        self._by_points += factor * vector.array.reshape(-1, 3)

    def add(self, other: ShapeGradient, factor: float) -> None:
        """Add ``factor`` times another number's derivatives."""
        self.at_nodes += factor * other.at_nodes
        self._by_points += factor * other._by_points

    @property
    def owned(self) -> np.ndarray:
        """Derivatives by the points that this rank owns, with all ranks' parts, (k, 3)."""
        every = self._by_points + self.coordinates.of_nodes.T @ self.at_nodes
        return self.coordinates.summed(every)

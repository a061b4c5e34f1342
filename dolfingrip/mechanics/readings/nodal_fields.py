"""Fields at the nodes of a body: stretch, stress, strain energy, and pressures on its surface."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Final

import basix
import numpy as np
import ufl
from dolfinx import fem, la
from scipy.sparse import csr_array

from dolfingrip.channels import CONTACT, ENERGY, INSIDE, MISES, STRESS, STRETCH
from dolfingrip.forms.kinematics import current_area_vector, deformation_gradient
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.pose_contact import PoseContact
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.points import AtPoints, Rule
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.principal import SIX, largest_eigenvalue

LEAST_FACING: Final = 0.5
"""Least part of the area around a vertex that a contact is taken to press on."""


class Nodes:
    """The nodes of a Lagrange space, which elements share.

    Attributes:
        space: the space.
        points: (n, 3) reference coordinates of an element's nodes.
        cells: this rank's cells.
        dofs: (cells, n) this rank's nodes of each of its cells.
        shared: (nodes,) number of cells that share each of this rank's nodes.
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        self.space = space
        self.points = space.element.basix_element.points
        self.cells = np.arange(space.mesh.topology.index_map(3).size_local, dtype=np.int32)
        self.dofs = space.dofmap.list[self.cells]
        self._map = space.dofmap.index_map
        nodes, count = self._map.size_local + self._map.num_ghosts, self.dofs.size
        places = self.dofs.ravel(), np.arange(count)
        self._adds = csr_array((np.ones(count), places), (nodes, count))
        self.shared = self.sums(np.ones(self.dofs.shape))

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sums at this rank's nodes, over all ranks, of values at the nodes of each cell.

        Args:
            values: (cells, n, …).

        Returns:
            (nodes, …).
        """
        columns = values.reshape(self.dofs.size, -1)
        summed = la.vector(self._map, columns.shape[1])
        summed.array[:] = (self._adds @ columns).ravel()
        summed.scatter_reverse(la.InsertMode.add)
        summed.scatter_forward()
        return summed.array.reshape(-1, *values.shape[2:])

    def means(self, values: np.ndarray) -> np.ndarray:
        """Means over the cells that share a node; shapes are those of :meth:`sums`."""
        return np.asarray((self.sums(values).T / self.shared).T)


class NodalFields(ABC):
    """Fields that are computed together, at the nodes of a Lagrange space."""

    @abstractmethod
    def values(self) -> Mapping[str, np.ndarray]:
        """Values at this rank's nodes at the present state, by the names of the fields' arrays."""


class PrincipalStretch(NodalFields):
    """Largest principal stretch λ₁ = √(largest eigenvalue of C), the mean of elements at a node.

    Args:
        u: displacement.
        nodes: where the stretch is wanted.
    """

    def __init__(self, u: fem.Function, nodes: Nodes) -> None:
        f = deformation_gradient(u)
        self._nodes = nodes
        self._strain = fem.Expression(f.T * f, nodes.points, jit_options=jit.options())

    def values(self) -> Mapping[str, np.ndarray]:
        nodes = self._nodes
        c = self._strain.eval(nodes.space.mesh, nodes.cells).reshape(*nodes.dofs.shape, 3, 3)
        return {STRETCH.array: nodes.means(np.sqrt(largest_eigenvalue(c)))}


class Stress(NodalFields):
    """Von Mises and largest principal Cauchy stress (MPa), and strain energy density (mJ/mm³).

    Each part of the energy is evaluated at the points at which it is integrated. In each element
    the linear function that fits these values best goes to the nodes, where elements are averaged
    (Hinton & Campbell, Int. J. Numer. Methods Eng. 8, 1974). Membranes have no part in it.

    Args:
        model: model of one body.
        nodes: where the stress is wanted.
    """

    def __init__(self, model: Model, nodes: Nodes) -> None:
        self._nodes = nodes
        mesh, potential = model.domain.mesh, model.potential
        f = deformation_gradient(model.u)
        self._parts = []
        for part in potential.solids:
            rule, cells = part.rule or potential.degree, part.cells
            cauchy = f * part.stress * f.T / ufl.det(f)
            entries = [cauchy[i, j] for i, j in zip(*SIX, strict=True)]
            at = AtPoints(ufl.as_vector([*entries, part.density]), mesh, rule, cells)
            carry = to_nodes(mesh.basix_cell(), rule, nodes.points)
            self._parts.append((at, carry, nodes.cells if cells is None else cells))

    def values(self) -> Mapping[str, np.ndarray]:
        seven: np.ndarray = np.zeros((*self._nodes.dofs.shape, 7))
        for at, carry, cells in self._parts:
            seven[cells] += carry @ at.values().reshape(len(cells), -1, 7)
        *six, energy = self._nodes.means(seven).T
        tensor = np.empty((len(energy), 3, 3))
        tensor[(..., *SIX)] = tensor[(..., *SIX[::-1])] = np.transpose(six)
        deviator = tensor - np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
        return {
            MISES.array: np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2))),
            STRESS.array: largest_eigenvalue(tensor),
            ENERGY.array: np.maximum(energy, 0.0),
        }


class ContactPressure(NodalFields):
    """Pressure (kPa) of all contacts on the deformed surface, folds and walls inside included.

    The forces of a contact act on all nodes. Those of an edge are shared between its ends, so each
    vertex has a force, and the oriented area of the surface around it. The pressure is the force by
    the area that faces it: of a vertex on an edge, only one of the faces may touch something. On a
    facet the pressure is linear.

    Args:
        model: model of one body.
        nodes: where the pressure is wanted.
    """

    def __init__(self, model: Model, nodes: Nodes) -> None:
        self._model, self._nodes = model, nodes
        self._terms = [t for t in model.terms if isinstance(t, BarrierContact | PoseContact)]
        mesh, space = model.domain.mesh, model.u.function_space
        vertices = fem.functionspace(mesh, ("Lagrange", 1, (3,)))
        self._corners, self._own = Nodes(vertices), Nodes(space)
        linear = self._corners.space.element.basix_element
        self._share = linear.tabulate(0, self._own.points)[0, :, :, 0]
        self._carry = linear.tabulate(0, nodes.points)[0, :, :, 0]
        outwards = current_area_vector(model.u, ufl.FacetNormal(mesh))
        test = ufl.TestFunction(vertices)
        surface = ufl.ds(domain=mesh, metadata={"quadrature_degree": 4})
        self._areas = to_assemble(ufl.inner(outwards, test) * surface)
        # the plane of symmetry is no surface: by symmetry, the surface's normals lie in it there
        at = vertices.tabulate_dof_coordinates()
        self._free = np.ones((len(at), 3))
        if model.domain.half:
            self._free[np.abs(at[:, 1]) < 1e-6 * np.ptp(at, axis=0).max(), 1] = 0.0

    def at_vertices(self) -> tuple[np.ndarray, np.ndarray]:
        """Pressures (n,) (MPa) at this rank's vertices, and (n, 3) oriented areas (mm²)."""
        model, nodes = self._model, self._own
        gradient = Gradient(model.unknowns)
        for term in self._terms:
            term.add_gradient(model.u.x.array, gradient)
        forces = fem.Function(model.u.function_space)
        owned = gradient.at_nodes
        forces.x.array[: owned.size] = owned.ravel()
        forces.x.scatter_forward()
        alone = forces.x.array.reshape(-1, 3) / nodes.shared[:, None]
        force = self._corners.sums(self._share.T @ alone[nodes.dofs])
        areas = fem.assemble_vector(self._areas)
        areas.scatter_reverse(la.InsertMode.add)
        areas.scatter_forward()
        area = areas.array.reshape(-1, 3) * self._free
        size, area_mm2 = (np.linalg.norm(vectors, axis=1) for vectors in (force, area))
        ahead = (force * area).sum(axis=1) / np.where(size > 0, size, 1.0)
        facing = np.maximum(ahead, LEAST_FACING * area_mm2)
        return size / np.where(facing > 0, facing, np.inf), area

    def values(self) -> Mapping[str, np.ndarray]:
        pressure_kPa = 1e3 * self.at_vertices()[0]
        return {CONTACT.array: self._nodes.means(pressure_kPa[self._corners.dofs] @ self._carry.T)}


class CavityPressure(NodalFields):
    """Gauge pressure (kPa) of the cavity that a node's wall encloses, and 0 at all other nodes.

    Args:
        pressures: by the names of the cavities.
        model: model of one body.
        nodes: where the pressure is wanted.
    """

    def __init__(self, pressures: Mapping[str, Control], model: Model, nodes: Nodes) -> None:
        self._zeros = np.zeros(len(nodes.shared))
        self._walls = [
            (fem.locate_dofs_topological(nodes.space, 2, model.domain.facets(name)), pressure)
            for name, pressure in pressures.items()
        ]

    def values(self) -> Mapping[str, np.ndarray]:
        if not self._walls:
            return {}
        pressures = self._zeros.copy()
        for at, pressure in self._walls:
            pressures[at] = pressure.value
        return {INSIDE.array: pressures}


def to_nodes(cell: basix.CellType, rule: int | Rule, nodes: np.ndarray) -> np.ndarray:
    """Return the matrix that carries values at integration points to the nodes of an element.

    Args:
        cell: kind of the element.
        rule: integration rule, or its degree.
        nodes: (n, 3) reference coordinates.

    Returns:
        Shape (n, points): values there of the linear, on hexahedra trilinear, function that fits
        best.

    >>> to_nodes(basix.CellType.tetrahedron, 1, np.zeros((1, 3))).round(6)
    array([[1.]])
    """
    points = rule.points if isinstance(rule, Rule) else basix.make_quadrature(cell, rule)[0]
    linear = basix.create_element(basix.ElementFamily.P, cell, 1)
    from_points, at_nodes = (linear.tabulate(0, x)[0, :, :, 0] for x in (points, nodes))
    return np.asarray(at_nodes @ np.linalg.pinv(from_points))

"""Small solids for verification, all with the same forms so that they compile once.

Every solid has the same regions in the same order (empty where it lacks one) and the same
energies, each with a constant that switches it on: the kernels are then the same for all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.config import KPA
from dolfingrip.forms import cavity_pressure, neo_hookean
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.compatibility import points_of_cells
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.newton.tangent import Tangent

REGIONS = ("cavity", "clamp", "skin", "tip", "symmetry", "facing plate")
FORCE_DEGREE = {1: 2, 2: 5}
"""Points of the body force: its error must stay below the elements' own."""
FAR = 1e3
"""Gap of a plate that is out of reach (mm)."""

Where = Callable[[np.ndarray], np.ndarray]


def domain(
    solid: mesh.Mesh, regions: Mapping[str, Where | np.ndarray], *, half: bool = False
) -> Domain:
    """``solid`` with regions given by facets or by where all their vertices are."""
    solid.topology.create_connectivity(2, 3)
    solid.topology.create_connectivity(3, 2)
    found = dict.fromkeys(REGIONS, np.empty(0, dtype=np.int32))
    for name, where in regions.items():
        found[name] = (
            where
            if isinstance(where, np.ndarray)
            else (mesh.locate_entities_boundary(solid, 2, where))
        )
    return Domain(solid, found, half)


def plane(axis: int, value: float) -> Where:
    """Points of the plane ``x[axis] = value``."""
    return lambda x: np.isclose(x[axis], value, atol=1e-9)


def box(
    cells: tuple[int, int, int],
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    irregular: float = 0.0,
) -> mesh.Mesh:
    """A box from the origin; inner vertices moved by up to ``irregular`` of a cell."""
    solid = mesh.create_box(MPI.COMM_SELF, [np.zeros(3), np.array(size)], cells)
    x = solid.geometry.x
    inner = np.all((x > 1e-9) & (x < np.array(size) - 1e-9), axis=1)
    moves = np.random.default_rng(7).uniform(-1, 1, x.shape) * np.array(size) / np.array(cells)
    x[inner] += irregular * moves[inner]
    return solid


def hollow_cube() -> Domain:
    """A cube of 3 mm with a closed cavity of 1 mm in its middle; its base is the clamp."""
    whole = box((3, 3, 3), (3.0, 3.0, 3.0))
    middle = mesh.compute_midpoints(whole, 3, np.arange(162, dtype=np.int32))
    solid = mesh.create_submesh(
        whole, 3, np.flatnonzero(np.any(np.abs(middle - 1.5) > 0.5, axis=1)).astype(np.int32)
    )[0]
    inside = lambda x: np.all((x > 0.9) & (x < 2.1), axis=0)  # noqa: E731
    skin = lambda x: np.any((x < 1e-9) | (x > 3 - 1e-9), axis=0)  # noqa: E731
    return domain(
        solid,
        {"cavity": inside, "clamp": plane(2, 0.0), "skin": skin, "facing plate": plane(0, 0.0)},
    )


@dataclass(slots=True)
class Body:
    """A model and the constants of its energies."""

    model: Model
    mu: fem.Constant
    lmbda: fem.Constant
    pressure: fem.Constant
    body_force: fem.Function
    plate: RigidPlate
    contact: BarrierContact | None = None

    def touch(self, contact: BarrierContact) -> None:
        """Give the body contact, in place of its present one."""
        self.contact = contact
        self.model.terms = [self.plate, contact]

    @property
    def u(self) -> fem.Function:
        """Displacement (mm)."""
        return self.model.u

    @property
    def nodes(self) -> np.ndarray:
        """Reference positions (n, 3) of the displacement nodes (mm)."""
        return np.asarray(self.u.function_space.tabulate_dof_coordinates())

    def displace(self, values: np.ndarray) -> None:
        """Set the displacement to (n, 3) nodal values (mm)."""
        self.u.x.array[:] = np.asarray(values).ravel()

    def displacement(self) -> np.ndarray:
        """Nodal displacement (n, 3) in mm."""
        return self.u.x.array.reshape(-1, 3).copy()

    def nodes_in(self, region: str) -> np.ndarray:
        """Displacement nodes of a region."""
        return np.asarray(
            fem.locate_dofs_topological(self.u.function_space, 2, self.model.domain.facets(region))
        )

    def hold(self, where: Where, *components: int) -> None:
        """Hold components of the nodes ``where`` at whatever value they have."""
        space = self.u.function_space
        nodes = np.flatnonzero(where(self.nodes.T)).astype(np.int32)
        for component in components or (0, 1, 2):
            # located in the subspace: dofs of the whole space, which supports count in
            self.model.supports.append(
                fem.dirichletbc(PETSc.ScalarType(0.0), 3 * nodes + component, space.sub(component))
            )

    def energy(self) -> float:
        """Π (mJ)."""
        return self.model.energy()

    def gradient(self) -> np.ndarray:
        """Gradient (n, 3) of Π (N), reactions included."""
        return self.model.reactions()

    def tangent(self) -> PETSc.Mat:
        """Hessian of all energies (N/mm), fresh carried stress; 1 on the diagonal of supports."""
        self.model.carried.reset()
        tangent = Tangent(self.model)
        tangent.assemble()
        return tangent.matrix


def body(
    solid: Domain,
    degree: int,
    *,
    mu: float = 1.0,
    nu: float = 0.45,
    carried: bool = True,
    barrier_mm: float = 0.1,
    stiffness_MPa: float = 1.0,
    normal: tuple[float, float, float] = (1.0, 0.0, 0.0),
) -> Body:
    """A neo-Hookean solid with every energy, the loads at 0 and the plate far away."""
    space = fem.functionspace(
        solid.mesh, basix.ufl.element("Lagrange", "tetrahedron", degree, shape=(3,))
    )
    u = fem.Function(space, name="displacement_mm")
    moduli = [
        fem.Constant(solid.mesh, PETSc.ScalarType(value))
        for value in (mu, 2 * mu * nu / (1 - 2 * nu))
    ]
    pressure = fem.Constant(solid.mesh, PETSc.ScalarType(0.0))
    points = basix.ufl.quadrature_element(
        "tetrahedron", value_shape=(3,), degree=FORCE_DEGREE[degree]
    )
    force = fem.Function(fem.functionspace(solid.mesh, points))
    plate = RigidPlate(
        u,
        solid,
        "facing plate",
        np.array(normal),
        gap_mm=FAR,
        width_mm=barrier_mm,
        stiffness_MPa=stiffness_MPa,
    )
    dx = ufl.Measure("dx", solid.mesh, metadata={"quadrature_degree": FORCE_DEGREE[degree]})
    cavity = solid.surface("cavity", quadrature_degree=2 * degree)
    potential = Potential(
        u,
        [lambda strain: neo_hookean.energy(strain, *moduli)],
        [
            cavity_pressure.energy(u, solid.mesh, pressure) * cavity,
            -ufl.inner(force, u) * dx,
        ],
        carried=carried,
    )
    model = Model(solid, u, potential, [], {"pressure_kPa": Control(pressure, KPA)}, [plate])
    return Body(model, moduli[0], moduli[1], pressure, force, plate)


def join(solids: Sequence[mesh.Mesh], offsets: np.ndarray) -> mesh.Mesh:
    """One mesh of several straight-edged solids that share no vertex, each moved."""
    points, cells, count = [], [], 0
    for solid, offset in zip(solids, offsets, strict=True):
        points.append(solid.geometry.x + offset)
        cells.append(points_of_cells(solid.geometry).astype(np.int64) + count)
        count += len(solid.geometry.x)
    return tetrahedra(np.concatenate(points), np.concatenate(cells))


def tetrahedra(points: np.ndarray, cells: np.ndarray) -> mesh.Mesh:
    """A mesh from (n, 3) points and (m, 4) cells."""
    element = basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,))
    return mesh.create_mesh(
        MPI.COMM_SELF,
        np.asarray(cells, dtype=np.int64),
        x=np.asarray(points, dtype=float),
        e=ufl.Mesh(element),
    )

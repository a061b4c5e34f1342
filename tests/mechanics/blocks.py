"""Boxes of straight tetrahedra as bodies, each of one material."""

from __future__ import annotations

from collections.abc import Sequence

import basix.ufl
import dolfinx
import numpy as np
from dolfinx import fem
from mechanics import bodies
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.forms import neo_hookean
from dolfingrip.mechanics.model import body
from dolfingrip.mechanics.model.body import DeformableBody
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.potential import Potential, StrainEnergy
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.meshes.solid import SolidMesh, assemble, boundary, faces

SIDES = {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1), "below": (2, 0),
         "above": (2, 1)}  # fmt: skip
"""Axis and end of each of a box' surface groups."""


def block(
    cells: tuple[int, int, int],
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> SolidMesh:
    """A box with its six sides as groups."""
    box = bodies.box(cells, size)
    corners = np.asarray(box.geometry.dofmap, dtype=np.int64)
    points = np.asarray(box.geometry.x)
    edges = points[corners[:, 1:]] - points[corners[:, :1]]
    turned = np.linalg.det(edges) < 0
    corners[turned] = corners[turned][:, [0, 2, 1, 3]]
    outside = faces(corners)[boundary(corners)]
    at = points[outside]
    groups = {}
    for name, (axis, end) in SIDES.items():
        groups[name] = outside[np.isclose(at[:, :, axis], end * size[axis]).all(axis=1)]
    return assemble(points + np.array(origin), corners, groups)


class NeoHooke:
    """A material of given Young's modulus (MPa) and Poisson's ratio."""

    def __init__(self, young_MPa: float, nu: float) -> None:
        self.young_MPa = young_MPa
        self.mu = young_MPa / (2 * (1 + nu))
        self.lmbda = 2 * self.mu * nu / (1 - 2 * nu)

    def __call__(self, mesh: dolfinx.mesh.Mesh) -> Sequence[StrainEnergy]:
        moduli = [fem.Constant(mesh, PETSc.ScalarType(value)) for value in (self.mu, self.lmbda)]
        return [lambda strain: neo_hookean.energy(strain, *moduli)]


def model(
    solids: Sequence[DeformableBody],
    *,
    degree: int = 1,
    comm: MPI.Comm = MPI.COMM_SELF,
    carried: bool = True,
) -> Model:
    """A model of bodies of tetrahedra without loads."""
    domain = body.assembled(comm, solids)
    element = basix.ufl.element("Lagrange", "tetrahedron", degree, shape=(3,))
    space = fem.functionspace(domain.mesh, element)
    u = fem.Function(space, name="displacement_mm")
    energies = body.strain_energies(domain, solids)
    potential = Potential(u, energies, carried=carried, domain=domain)
    return Model(domain, u, potential, at_rest(space, domain, body.held(solids)), {})

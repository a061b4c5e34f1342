"""Cook's membrane at finite strain: a panel in plane strain, clamped left, sheared right.

Corners (0, 0), (48, 44), (48, 60), (0, 44) mm; μ = 80.194 MPa; a dead vertical load of 100 N for
each mm of thickness, spread over the right edge. Nearly incompressible, its top right corner
rises by 6.9 mm (Simo & Armero, Int. J. Numer. Methods Eng. 33, 1992; Elguedj, Bazilevs, Calo &
Hughes, Comput. Methods Appl. Mech. Eng. 197, 2008), unless the element locks.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.config import Config
from dolfingrip.forms import mixed_bulk_modulus, neo_hookean
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import displacement_element, pressure_field
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath

MU_MPA = 80.194
LOAD_N = 100.0
"""For each mm of thickness."""
EDGE_MM = 16.0
"""Length of the loaded edge."""


def panel(cells: int) -> mesh.Mesh:
    """``cells`` × ``cells`` × 1 boxes of six tetrahedra each, as thick as they are long."""
    thickness = 48.0 / cells
    corners = [np.zeros(3), np.array([1.0, 1.0, thickness])]
    solid = mesh.create_box(MPI.COMM_WORLD, corners, (cells, cells, 1))
    x, y = solid.geometry.x[:, 0].copy(), solid.geometry.x[:, 1].copy()
    solid.geometry.x[:, 0] = 48 * x
    solid.geometry.x[:, 1] = 44 * x + y * (44 - 28 * x)
    return solid


def model(element: str, cells: int, nu: float) -> Model:
    """The unloaded panel; its control is ``load_N``."""
    solid = panel(cells)
    solid.topology.create_connectivity(2, 3)
    ends = {
        name: lambda x, at=at: np.isclose(x[0], at) for name, at in (("left", 0), ("right", 48))
    }
    faces = {name: mesh.locate_entities_boundary(solid, 2, where) for name, where in ends.items()}
    thickness = 48.0 / cells
    faces["sides"] = mesh.locate_entities_boundary(
        solid, 2, lambda x: np.isclose(x[2], 0) | np.isclose(x[2], thickness)
    )
    domain = Domain(solid, faces, half=False)
    space = fem.functionspace(solid, displacement_element(element))
    u = fem.Function(space)
    p = pressure_field(element, solid)
    moduli = [fem.Constant(solid, MU_MPA), fem.Constant(solid, 2 * MU_MPA * nu / (1 - 2 * nu))]
    load = fem.Constant(solid, PETSc.ScalarType(0.0))

    def energy(strain: Expr) -> Expr:
        if p is None:
            return neo_hookean.energy(strain, *moduli)
        mu, lmbda = moduli
        shape = neo_hookean.energy(strain, mu, 0.0)
        return shape + mixed_bulk_modulus.energy(strain, p, lmbda)

    work = (
        -load
        / EDGE_MM
        * u[1]
        * domain.surface("right", quadrature_degree=u.function_space.ufl_element().degree)
    )
    potential = Potential(u, [energy], [work], p=p)
    supports = []
    for axis, names in ((0, ["left"]), (1, ["left"]), (2, ["left", "sides"])):
        along = space.sub(axis)
        held = fem.locate_dofs_topological(along, 2, domain.facets(*names))
        supports.append(fem.dirichletbc(PETSc.ScalarType(0.0), held, along))
    return Model(domain, u, potential, supports, {"load_N": Control(load)}, p=p)


def corner_rise_mm(panel: Model) -> float:
    """Vertical displacement of the top right corner, its mean across the thickness."""
    nodes = panel.u.function_space.tabulate_dof_coordinates()
    corner = np.isclose(nodes[:, 0], 48) & np.isclose(nodes[:, 1], 60)
    return float(panel.u.x.array.reshape(-1, 3)[corner, 1].mean())


def shear(element: str, cells: int, nu: float) -> dict[str, Any]:
    """Load the panel fully, in four steps or more.

    Raises:
        SystemExit: where the load path ends early.
    """
    panel = model(element, cells, nu)
    newton = Newton(panel, Config().solver)
    start = time.perf_counter()
    arrival = LoadPath(newton, {"load_N": LOAD_N / 4}).advance({"load_N": LOAD_N})
    if arrival.failure is not None:
        raise SystemExit(arrival.failure.sentence())
    return {
        "dofs": panel.dofs,
        "elements": int(panel.domain.mesh.topology.index_map(3).size_global),
        "solve_s": time.perf_counter() - start,
        "iterations": newton.counts.iterations,
        "rise_mm": corner_rise_mm(panel),
    }

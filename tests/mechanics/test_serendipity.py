"""The 20-node brick: its polynomials, patch test and modes without energy."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfingrip.forms import neo_hookean
from dolfingrip.mechanics.model.element import displacement_element, integration_degree
from dolfingrip.mechanics.model.potential import Potential

SEED = 20


def _space(cells: int) -> fem.FunctionSpace:
    box = mesh.create_box(
        MPI.COMM_SELF, [(0, 0, 0), (3, 2, 1)], (cells, cells, 1), mesh.CellType.hexahedron
    )
    return fem.functionspace(box, displacement_element("S2"))


def test_holds_quadratic_fields_at_its_nodes() -> None:
    """Superlinear degree 2: all of x^2, xy, xyz, x^2 y z and their like (Arnold & Awanou 2011)."""
    print("seed", SEED)
    a = np.random.default_rng(SEED).standard_normal((3, 4))
    space = _space(2)
    u = fem.Function(space)

    def field(x: np.ndarray) -> np.ndarray:
        terms = np.stack([x[0] ** 2, x[0] * x[1] * x[2], x[2] ** 2 * x[0] * x[1], x[1] * x[2]])
        return a @ terms

    u.interpolate(field)
    nodes = space.tabulate_dof_coordinates()
    np.testing.assert_allclose(u.x.array.reshape(-1, 3), field(nodes.T).T, atol=1e-12)
    x = ufl.SpatialCoordinate(space.mesh)
    exact = ufl.dot(
        ufl.as_matrix(a.tolist()),
        ufl.as_vector([x[0] ** 2, x[0] * x[1] * x[2], x[2] ** 2 * x[0] * x[1], x[1] * x[2]]),
    )
    dx = ufl.Measure("dx", space.mesh, metadata={"quadrature_degree": 8})
    error = fem.assemble_scalar(fem.form(ufl.inner(u - exact, u - exact) * dx))
    assert abs(error) < 1e-24


@pytest.mark.parametrize(("cells", "silent"), [(1, 6 + 6), (2, 6)])
def test_modes_without_energy(cells: int, silent: int) -> None:
    """Eight points leave six such modes to one brick alone, but none to bricks that share faces.

    The counts are those of Bićanić & Hinton (Int. J. Numer. Methods Eng. 14, 1979).
    """
    space = _space(cells)
    assert integration_degree(space) == 3
    u = fem.Function(space)
    mu, lmbda = (fem.Constant(space.mesh, value) for value in (1.0, 2.0))
    potential = Potential(u, [lambda strain: neo_hookean.energy(strain, mu, lmbda)], carried=False)
    stiffness = fem.assemble_matrix(potential.tangent).to_dense()
    values = np.linalg.eigvalsh(stiffness)
    assert (np.abs(values) < 1e-10 * values[-1]).sum() == silent
    assert values[0] > -1e-10 * values[-1]

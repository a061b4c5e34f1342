"""Rates of convergence on a manufactured solution at finite strain.

Elements of order k with a rule exact for polynomials of degree 2k − 2 converge with k + 1 in
L2 and k in H1 (Ciarlet, The Finite Element Method for Elliptic Problems, section 4.1): 2 and 1
for P1, 3 and 2 for P2, whose rules here are of degree 1 and 2.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import basix
import numpy as np
import pytest
import ufl
from dolfinx import fem
from support import bodies

from dolfingrip.config import Solver
from dolfingrip.forms import neo_hookean
from dolfingrip.forms.kinematics import deformation_gradient, green_lagrange
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.newton.newton import Newton

AMPLITUDE = 0.08
MESHES = {1: (3, 6, 12), 2: (2, 4, 8)}
NORM_DEGREE = 6
"""Well above the elements' own, so that the norms' error does not show."""


def exact(x: Any, m: ModuleType) -> list[Any]:
    """A smooth displacement (mm) that shears, bends and swells, in numpy or UFL."""
    return [
        AMPLITUDE * m.sin(2 * x[1] + x[2]),
        AMPLITUDE * m.cos(x[0] - 2 * x[2]),
        AMPLITUDE * m.sin(2 * x[0] + x[1] * x[2]),
    ]


def set_body_force(solid: bodies.Body) -> None:
    """b = −Div P of the exact displacement, by UFL from the energy itself."""
    mesh = solid.model.domain.mesh
    u = ufl.as_vector(exact(ufl.SpatialCoordinate(mesh), ufl))
    strain = ufl.variable(green_lagrange(u))
    stress = ufl.diff(neo_hookean.energy(strain, solid.mu, solid.lmbda), strain)
    rule = bodies.FORCE_DEGREE[solid.u.function_space.ufl_element().degree]
    force = fem.Expression(
        -ufl.div(deformation_gradient(u) * stress),
        basix.make_quadrature(basix.CellType.tetrahedron, rule)[0],
        jit_options=jit.options(),
    )
    cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
    solid.body_force.x.array[:] = force.eval(mesh, cells).ravel()


def errors(degree: int, n: int, nu: float) -> tuple[float, float]:
    """L2 and H1-seminorm of the error on n³ cubes of six tetrahedra."""
    solid = bodies.body(bodies.domain(bodies.box((n, n, n)), {}), degree, nu=nu)
    set_body_force(solid)
    solid.displace(np.stack(exact(solid.nodes.T, np), axis=1))
    solid.hold(lambda x: np.any(np.isclose(x, 0) | np.isclose(x, 1), axis=0))
    assert Newton(solid.model, Solver(rtol=1e-10)).solve().converged

    mesh = solid.model.domain.mesh
    dx = ufl.Measure("dx", mesh, metadata={"quadrature_degree": NORM_DEGREE})
    error = solid.u - ufl.as_vector(exact(ufl.SpatialCoordinate(mesh), ufl))
    l2, h1 = (
        np.sqrt(fem.assemble_scalar(fem.form(ufl.inner(e, e) * dx, jit_options=jit.options())))
        for e in (error, ufl.grad(error))
    )
    return float(l2), float(h1)


def test_solution_is_at_finite_strain() -> None:
    """The largest principal Green–Lagrange strain of the exact field is above 0.15."""
    step = 1e-6
    x = np.random.default_rng(3).uniform(0, 1, (3, 500))
    gradient = np.array(
        [
            (
                np.array(exact(x + step * e[:, None], np))
                - np.array(exact(x - step * e[:, None], np))
            )
            / (2 * step)
            for e in np.eye(3)
        ]
    )  # (derivative, component, point)
    f = np.eye(3) + gradient.transpose(2, 1, 0)
    strain = (f.transpose(0, 2, 1) @ f - np.eye(3)) / 2
    principal = np.linalg.eigvalsh(strain)
    assert principal.max() > 0.15
    assert principal.min() < -0.1


@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_rates(degree: int, nu: float) -> None:
    """Observed orders between successive meshes reach the theory's, the last within 0.05."""
    found = np.array([errors(degree, n, nu) for n in MESHES[degree]])
    rates = np.log2(found[:-1] / found[1:])
    print(f"P{degree} nu {nu}: errors\n{found}\nrates\n{rates}")
    assert rates[-1, 0] > degree + 1 - 0.05
    assert rates[-1, 1] > degree - 0.05

"""Homogeneous deformation: the patch test and the uniaxial coupon."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from support import bodies

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton

SEED = 5
NU = 0.45
STRICT = Solver(rtol=1e-13, atol_N=1e-13)


@pytest.fixture
def irregular(degree: int) -> bodies.Body:
    """A cube of 1 mm with displaced inner vertices."""
    solid = bodies.domain(bodies.box((3, 3, 3), irregular=0.25), {})
    return bodies.body(solid, degree, nu=NU)


def surface_of_cube(x: np.ndarray) -> np.ndarray:
    """Points on the unit cube's surface."""
    return np.any(np.isclose(x, 0) | np.isclose(x, 1), axis=0)


def test_patch(irregular: bodies.Body) -> None:
    """Boundary values of an affine map give the affine map inside (Irons' patch test).

    Every element then has the same F, which any order and rule represent: only round-off and
    Newton's tolerance are left.
    """
    print("seed", SEED)
    gradient = np.random.default_rng(SEED).uniform(-0.2, 0.2, (3, 3))
    exact = irregular.nodes @ gradient.T
    inner = ~surface_of_cube(irregular.nodes.T)
    start = exact.copy()
    start[inner] += 0.02
    irregular.displace(start)
    irregular.hold(surface_of_cube)

    assert Newton(irregular.model, STRICT).solve().converged
    assert inner.sum() > 7
    np.testing.assert_allclose(irregular.displacement(), exact, atol=1e-12)
    # and the stress that holds it is in equilibrium with itself
    np.testing.assert_allclose(irregular.gradient().sum(axis=0), 0, atol=1e-12)


@pytest.mark.parametrize("stretch", [0.7, 1.001, 1.5])
def test_uniaxial_coupon(irregular: bodies.Body, stretch: float) -> None:
    """Transverse stretch and force of a bar with free sides, against their closed form.

    P = ∂ψ/∂F for F = diag(λ, t, t): μ(t² − 1) + Λ ln(λt²) = 0 sets t, and the nominal
    stress is μ(λ − 1/λ) + Λ ln(λt²)/λ (Bonet & Wood, section 6.4.3, eq. 6.28).
    """
    mu, lmbda = float(irregular.mu.value), float(irregular.lmbda.value)
    transverse = brentq(
        lambda t: mu * (t**2 - 1) + lmbda * np.log(stretch * t**2), 0.3, 3.0, xtol=1e-15
    )
    nominal = mu * (stretch - 1 / stretch) + lmbda * np.log(stretch * transverse**2) / stretch

    # supports hold a dof at the value it has: the ends start, and stay, at the stretch
    irregular.displace(irregular.nodes * [0, 0, stretch - 1])
    for axis in range(3):
        irregular.hold(bodies.plane(axis, 0.0), axis)
    irregular.hold(bodies.plane(2, 1.0), 2)
    assert Newton(irregular.model, STRICT).solve().converged

    expected = irregular.nodes * [transverse - 1, transverse - 1, stretch - 1]
    np.testing.assert_allclose(irregular.displacement(), expected, atol=1e-10)
    end = np.isclose(irregular.nodes[:, 2], 1.0)
    assert irregular.gradient()[end, 2].sum() == pytest.approx(nominal, rel=1e-8)

"""St. Venant–Kirchhoff strain energy: quadratic in the Green–Lagrange strain."""

import ufl
from ufl.core.expr import Expr


def energy(strain: Expr, young: Expr, nu: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³), for small strain at any rotation.

    ψ = μ E : E + λ/2 (tr E)²,   μ = Y/(2 (1 + ν)),   λ = Y ν/((1 + ν)(1 − 2ν))

    (Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., eq. 6.28).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        young: Young's modulus Y (MPa).
        nu: Poisson's ratio ν.

    Example:
        A bar of ν = 0 has the energy Y E²/2.

        >>> from dolfingrip.forms.evaluate import number
        >>> stretched = ufl.as_matrix([[0, 0, 0], [0, 0, 0], [0, 0, 0.1]])
        >>> round(number(energy(stretched, 2.0, 0.0)), 9)
        0.01
    """
    mu = young / (2 * (1 + nu))
    lmbda = young * nu / ((1 + nu) * (1 - 2 * nu))
    return mu * ufl.inner(strain, strain) + lmbda / 2 * ufl.tr(strain) ** 2

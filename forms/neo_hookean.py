"""Compressible neo-Hookean strain energy."""

import ufl
from ufl.core.expr import Expr


def energy(strain: Expr, mu: Expr, lmbda: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³).

    ψ = μ/2 (I₁ − 3 − 2 ln J) + λ/2 (ln J)²

    with I₁ = tr C, J = √det C, C = 2E + I (Bonet & Wood, Nonlinear Continuum Mechanics for
    Finite Element Analysis, 2nd ed., eq. 6.27).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        mu: shear modulus μ (MPa).
        lmbda: first Lamé parameter λ (MPa); the bulk modulus is λ + 2μ/3.

    Example:
        A bar of constant volume has P = μ (λ − λ⁻²), here 2 − 1/4 at a stretch of 2.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 1.0, 9.0), 2.0), 9)
        1.75
    """
    c = 2 * strain + ufl.Identity(3)
    ln_j = ufl.ln(ufl.det(c)) / 2
    # tr C − 3 = 2 tr E, written so: the difference would cancel at small strain
    return mu / 2 * (2 * ufl.tr(strain) - 2 * ln_j) + lmbda / 2 * ln_j**2

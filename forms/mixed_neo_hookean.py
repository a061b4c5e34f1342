"""Neo-Hookean energy of displacement and pressure, for nearly incompressible solids."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms import neo_hookean


def energy(strain: Expr, p: Expr, mu: Expr, lmbda: Expr) -> Expr:
    """Perturbed Lagrangian per reference volume (MPa = mJ/mm³).

    L = μ/2 (I₁ − 3 − 2 ln J) + p ln J − p²/(2λ)

    The volumetric part λ/2 (ln J)² of :mod:`~dolfingrip.forms.neo_hookean` is replaced by its
    Legendre transform. Where L is stationary in p it is the same energy, with p = λ ln J. But p
    may be chosen smoother than ln J is, and it stays finite as λ grows (Simo, Taylor & Pister,
    Comput. Methods Appl. Mech. Eng. 51, 1985; Bonet & Wood, section 8.6).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        p: pressure (MPa), positive in tension.
        mu: shear modulus μ (MPa).
        lmbda: first Lamé parameter λ (MPa).

    Example:
        A cube whose sides are held has P = μ (λ − 1/λ) + p/λ: 1.5 + 3 at a stretch of 2.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 6.0, 1.0, 9.0), 2.0, held=True), 9)
        4.5
    """
    ln_j = ufl.ln(ufl.det(2 * strain + ufl.Identity(3))) / 2
    return neo_hookean.energy(strain, mu, 0 * lmbda) + p * ln_j - p**2 / (2 * lmbda)

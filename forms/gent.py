"""The Gent strain energy less the neo-Hookean one."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms import invariants

SMALL = 0.01
"""The share x of the limit below which ln(1 − x) is a series; its seventh term is round-off."""


def energy(strain: Expr, mu: Expr, inverse_limit: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³), added to the neo-Hookean one.

    ψ = −μ/2 [Jₘ ln(1 − x) + Ī₁ − 3],   x = (Ī₁ − 3)/Jₘ

    Chains have a limited length: ψ is unbounded at x = 1, and beyond it there is no state (Gent,
    Rubber Chem. Technol. 69, 1996). The limit is given by its inverse, so that chains of any length
    are 1/Jₘ = 0. There ψ is 0, and its derivative by 1/Jₘ is μ/4 (Ī₁ − 3)².

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        mu: shear modulus μ (MPa).
        inverse_limit: 1/Jₘ, from 0 on; Jₘ is the limit of Ī₁ − 3.

    Example:
        A bar of constant volume has P = μ (λ − λ⁻²) x/(1 − x), here x = 2/4 at a stretch of 2.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 1.0, 0.25), 2.0), 9)
        1.75
    """
    first, _ = invariants.isochoric(strain)
    x = first * inverse_limit
    series = sum(x**k / (k + 1) for k in range(1, 8))
    # at small x, ln(1 − x)/x would lose its digits or divide by 0
    large = ufl.max_value(x, SMALL)
    closed = -ufl.ln(1 - large) / large - 1
    return mu / 2 * first * ufl.conditional(ufl.lt(x, SMALL), series, closed)

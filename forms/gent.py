"""The Gent strain energy less the neo-Hookean one."""

from typing import Any

from ufl.core.expr import Expr

from dolfingrip.forms import isotropic
from dolfingrip.forms.functions import from_limit_on, ln, remaining
from dolfingrip.forms.jet import Jet

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
    return isotropic.energy(
        strain, lambda invariants: of_invariant(invariants.first, mu, inverse_limit)
    )


def of_invariant(first: Jet, mu: Any, inverse_limit: Any) -> Jet:
    """Return the energy by the first invariant, of expressions or of numbers.

    Args:
        first: Ī₁ − 3.
        mu: shear modulus μ (MPa).
        inverse_limit: 1/Jₘ, from 0 on.

    Returns:
        The energy (MPa = mJ/mm³) with its derivatives by the invariants.
    """
    x = first.f * inverse_limit
    left = remaining(x)
    # at small x, ln(1 − x)/x would lose its digits or divide by 0
    series = sum(x**k / (k + 1) for k in range(1, 8))
    factor = from_limit_on(x, SMALL, series, lambda large: -ln(remaining(large)) / large - 1)
    bend = mu / 2 * inverse_limit / (left * left)
    return first.through(mu / 2 * first.f * factor, mu / 2 * x / left, bend)

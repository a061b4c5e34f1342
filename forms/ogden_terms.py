"""Ogden's strain energy with any number of terms."""

from collections.abc import Sequence
from functools import reduce
from operator import add
from typing import Any

from ufl.core.expr import Expr

from dolfingrip.forms import isotropic
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet


def energy(strain: Expr, mu: Sequence[Expr], alpha: Sequence[Expr]) -> Expr:
    """Strain energy per reference volume at constant volume (MPa = mJ/mm³).

    ψ = Σ 2μ_k/α_k² (λ̄₁^α_k + λ̄₂^α_k + λ̄₃^α_k − 3)

    of the isochoric principal stretches (Ogden, Proc. R. Soc. A 326, 1972). The initial shear
    modulus is Σ μ_k. The powers come from :mod:`dolfingrip.forms.isotropic`.

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        mu: μ_k (MPa), of either sign.
        alpha: exponents α_k, of either sign but not 0.

    Example:
        A bar of constant volume has P = Σ 2μ/α (λ^(α−1) − λ^(−α/2−1)), here with α = −2 at a
        stretch of 2: 1 − 1/8.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, [1.0], [-2.0]), 2.0), 6)
        0.875
    """
    return isotropic.energy(strain, lambda invariants: of_powers(invariants, mu, alpha))


def of_powers(invariants: Invariants, mu: Sequence[Any], alpha: Sequence[Any]) -> Jet:
    """Energy of Ogden's terms from sums of powers of the stretches.

    Args:
        invariants: variables of the energy, in UFL or in numbers.
        mu: moduli of the terms (MPa).
        alpha: exponents of the stretches.

    Returns:
        The energy (MPa = mJ/mm³) with its derivatives by Ī₁ and Ī₂.
    """
    terms = [invariants.power_sum(a) * (2 * m / a**2) for m, a in zip(mu, alpha, strict=True)]
    return reduce(add, terms)

"""Strain energies that are polynomials of the invariants, such as Mooney–Rivlin's and Yeoh's."""

from collections.abc import Mapping
from typing import Any

from ufl.core.expr import Expr

from dolfingrip.forms import isotropic
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet, series


def energy(strain: Expr, c: Mapping[tuple[int, int], Expr]) -> Expr:
    """Strain energy per reference volume at constant volume (MPa = mJ/mm³).

    ψ = Σ C_ij (Ī₁ − 3)ⁱ (Ī₂ − 3)ʲ

    (Rivlin & Saunders, Phil. Trans. R. Soc. A 243, 1951). The initial shear modulus is
    2 (C₁₀ + C₀₁).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        c: C_ij (MPa) by (i, j).

    Example:
        A bar of constant volume has P = 2 (λ − λ⁻²)(∂ψ/∂Ī₁ + ∂ψ/∂Ī₂/λ), here with Ī₁ − 3 = 2 and
        C₀₁ = C₂₀ = 1 at a stretch of 2: 3.5 (4 + ½).

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> c = {(0, 1): 1.0, (2, 0): 1.0}
        >>> round(nominal_stress(lambda strain: energy(strain, c), 2.0), 9)
        15.75
    """
    return isotropic.energy(strain, lambda invariants: of_invariants(invariants, c))


def of_invariants(invariants: Invariants, c: Mapping[tuple[int, int], Any]) -> Jet:
    """Return the energy by the invariants, of expressions or of numbers.

    Args:
        invariants: of the isochoric stretches.
        c: C_ij (MPa) by (i, j).

    Returns:
        The energy (MPa = mJ/mm³) with its derivatives by the invariants.
    """
    return series(c, invariants.first, invariants.second)

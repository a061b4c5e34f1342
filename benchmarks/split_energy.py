"""The neo-Hookean energy of Abaqus and CalculiX, to compare like with like."""

import ufl
from ufl.core.expr import Expr


def energy(strain: Expr, mu: Expr, bulk: Expr) -> Expr:
    """Strain energy per reference volume (MPa), split into isochoric and volumetric parts.

    ψ = μ/2 (J^(−2/3) I₁ − 3) + K/2 (J − 1)²

    which is C₁₀ (Ī₁ − 3) + (J − 1)²/D₁ with C₁₀ = μ/2 and D₁ = 2/K (CalculiX 2.20 manual,
    *HYPERELASTIC, NEO HOOKE).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        mu: shear modulus μ (MPa).
        bulk: bulk modulus K (MPa), λ + 2μ/3.
    """
    c = 2 * strain + ufl.Identity(3)
    j = ufl.sqrt(ufl.det(c))
    # Ī₁ − 3 as one power of J less than one, so that little cancels at small strain
    isochoric = j ** (-2 / 3) * (2 * ufl.tr(strain)) + 3 * (j ** (-2 / 3) - 1)
    return mu / 2 * isochoric + bulk / 2 * (j - 1) ** 2

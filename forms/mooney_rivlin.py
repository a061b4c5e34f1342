"""What the Mooney–Rivlin strain energy has over the neo-Hookean one."""

from ufl.core.expr import Expr

from dolfingrip.forms import invariants


def energy(strain: Expr, c01: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³), beside the neo-Hookean one.

    ψ = C₀₁ [(Ī₂ − 3) − (Ī₁ − 3)]

    The second invariant is added and as much of the first is taken off, so that the initial shear
    modulus μ stays: together C₁₀ = μ/2 − C₀₁ (Rivlin & Saunders, Phil. Trans. R. Soc. A 243, 1951).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        c01: C₀₁ (MPa).

    Example:
        A bar of constant volume has P = 2 C₀₁ (λ − λ⁻²)(1/λ − 1), which softens it.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 1.0), 2.0), 9)
        -1.75
    """
    first, second = invariants.isochoric(strain)
    return c01 * (second - first)

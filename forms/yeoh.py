"""What the Yeoh strain energy has over the neo-Hookean one."""

from ufl.core.expr import Expr

from dolfingrip.forms import invariants


def energy(strain: Expr, c20: Expr, c30: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³), beside the neo-Hookean one.

    ψ = C₂₀ (Ī₁ − 3)² + C₃₀ (Ī₁ − 3)³

    (Yeoh, Rubber Chem. Technol. 66, 1993).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        c20: C₂₀ (MPa).
        c30: C₃₀ (MPa).

    Example:
        A bar of constant volume has P = 2 (λ − λ⁻²)(2 C₂₀ i + 3 C₃₀ i²), i = Ī₁ − 3, which is 2
        at a stretch of 2.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 0.5, 0.25), 2.0), 9)
        17.5
    """
    first, _ = invariants.isochoric(strain)
    return c20 * first**2 + c30 * first**3

"""What the one-term Ogden strain energy has over the neo-Hookean one."""

from ufl.core.expr import Expr

from dolfingrip.forms import invariants, powers


def energy(strain: Expr, mu: Expr, alpha: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³), beside the neo-Hookean one.

    ψ = 2μ/α² (λ̄₁ᵅ + λ̄₂ᵅ + λ̄₃ᵅ − 3) − μ/2 (Ī₁ − 3)

    It takes the neo-Hookean term off and puts Ogden's of the same initial modulus in its place
    (Ogden, Proc. R. Soc. A 326, 1972). The stretches' powers come from
    :mod:`dolfingrip.forms.powers`, the stress to 1e-3 at a stretch of 1.5.

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        mu: shear modulus μ (MPa).
        alpha: exponent α, from above −2 to below 4 and not 0; 2 is neo-Hooke.

    Example:
        A bar of constant volume has P = 2μ/α (λ^(α−1) − λ^(−α/2−1)) − μ (λ − λ⁻²), −0.1442
        at a stretch of 1.5 and α = 1.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 1.0, 1.0), 1.5), 4)
        -0.1442
    """
    s = alpha / 2
    first, second = invariants.isochoric(strain)
    # of both terms only this remains, which vanishes at s = 1
    more = (1 - s) / s * (first - powers.spread(first, second, s) / 2)
    return mu / 2 * more

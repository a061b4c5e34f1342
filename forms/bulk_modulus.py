"""Additional resistance to a change of volume, which another energy is added to."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms import invariants


def energy(strain: Expr, more: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³).

    ψ = ΔK/2 (ln J)²

    with J = √det C. The bulk modulus of the other energy rises by ΔK; at constant volume nothing
    changes (the volumetric part of Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element
    Analysis, 2nd ed., eq. 6.27).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        more: ΔK (MPa).

    Example:
        A cube whose sides are held has P = ΔK ln λ/λ, 1/e at a stretch of e.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 1.0), 2.718281828, held=True), 6)
        0.367879
    """
    ln_j = ufl.ln(ufl.det(invariants.right_cauchy_green(strain))) / 2
    return more / 2 * ln_j**2

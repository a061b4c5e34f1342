"""One stiffer or softer direction: the standard reinforcing energy."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms import invariants


def energy(strain: Expr, k: Expr, axis: Expr) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³), added to that of an isotropic solid.

    ψ = k/2 (Ī₄ − 1)²,   Ī₄ = a · C̄ a

    √Ī₄ is the stretch along a once the change of volume is taken out. At small strain Young's
    modulus along a rises by 4k where the solid is incompressible (Triantafyllidis & Abeyaratne, J.
    Appl. Mech. 50, 1983).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        k: stiffness (MPa); below 0 the axis is the softer direction.
        axis: unit vector a, (3,).

    Example:
        A bar of constant volume along a has P = 2k λ (λ² − 1).

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> z = ufl.as_vector([0, 0, 1])
        >>> round(nominal_stress(lambda strain: energy(strain, 1.0, z), 2.0), 9)
        12.0
    """
    along = ufl.inner(axis, invariants.isochoric_tensor(strain) * axis) - 1
    return k / 2 * along**2

"""Dead weight."""

import ufl
from ufl.core.expr import Expr


def energy(u: Expr, weight: Expr) -> Expr:
    """Potential of gravity per reference volume (mJ/mm³): −ρ g · u.

    Args:
        u: displacement (mm).
        weight: density times acceleration ρ g, (3,), in N/mm³.

    Example:
        Lifting 1.2e-5 N/mm³, a density of some 1200 kg/m³, by 5 mm takes 6e-5 mJ/mm³.

        >>> from dolfingrip.forms.evaluate import number
        >>> round(number(energy(ufl.as_vector([0, 0, 5]), ufl.as_vector([0, 0, -1.2e-5]))), 9)
        6e-05
    """
    return -ufl.inner(weight, u)

"""Dead weight."""

import ufl
from ufl.core.expr import Expr


def energy(u: Expr, weight: Expr) -> Expr:
    """Potential of gravity per reference volume (mJ/mm³): −ρ g · u.

    Args:
        u: displacement (mm).
        weight: density times acceleration, (3,), in N/mm³.
    """
    return -ufl.inner(weight, u)

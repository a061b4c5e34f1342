"""The largest principal strain as a smooth function of the deformation."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import green_lagrange

SQUARINGS = 5
"""How often E is squared: the sum below has the power 2^SQUARINGS of the strains."""

POWER = 2**SQUARINGS


def power_sum(u: Expr) -> Expr:
    """Σ eᵢ³² = tr(E³²) of the principal Green–Lagrange strains e, by five squarings.

    The mean of it over a solid, to the power 1/32, is near the largest strain and smooth where two
    principal strains are equal (as the global measure of stress in Yang & Chen, Struct. Optim. 12,
    1996). The largest stretch is √(1 + 2 e).

    Args:
        u: displacement (mm).

    Example:
        A stretch by 1.5 along x at constant volume.

        >>> from dolfingrip.forms.evaluate import displacement, number
        >>> u = displacement([[1.5, 0, 0], [0, 1.5**-0.5, 0], [0, 0, 1.5**-0.5]])
        >>> round((1 + 2 * number(power_sum(u)) ** (1 / POWER)) ** 0.5, 6)
        1.5
    """
    e = green_lagrange(u)
    for _ in range(SQUARINGS):
        e = e * e
    return ufl.tr(e)

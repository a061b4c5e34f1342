"""Air that is trapped in a closed cavity: p Vⁿ stays as it is."""

from __future__ import annotations

import ufl
from ufl.core.expr import Expr


def potential(pressure: Expr, volume: Expr, closed_at: Expr, ambient: Expr, n: float) -> Expr:
    """Complementary potential of trapped air (mJ), whose derivative by its pressure is its volume.

    φ(p) = ∫ V dp,   V(p) = V₀ (p₀/(p + pₐ))^{1/n}

    Π = φ(p) − p V(u) is stationary in p where the air's volume is the cavity's, and concave in it.
    In u it then has the force of p on the walls.

    Args:
        pressure: p in the cavity above that of the air around (MPa).
        volume: V₀ at which it was closed (mm³).
        closed_at: p₀, absolute pressure at which it was closed (MPa).
        ambient: pₐ, absolute pressure of the air around (MPa).
        n: polytropic exponent: 1 for air that keeps its temperature, 1.4 for an adiabatic change.

    Example:
        In 0.9 of its volume, air that was closed at pₐ and keeps its temperature has pₐ/9.

        >>> from dolfingrip.forms.evaluate import number
        >>> p = ufl.variable(ufl.as_ufl(0.101325 / 9))
        >>> round(number(ufl.diff(potential(p, 1000.0, 0.101325, 0.101325, 1.0), p)), 9)
        900.0
    """
    ratio = (pressure + ambient) / closed_at
    if n == 1:
        return volume * closed_at * ufl.ln(ratio)
    power = 1 - 1 / n
    return volume * closed_at / power * (ratio**power - 1)

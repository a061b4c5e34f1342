"""Mullins softening as a pseudo-elastic energy (Ogden & Roxburgh, Proc. R. Soc. A 455, 1999).

Below the largest energy W that a point has seen, its stress is η times that of the virgin solid,

    η = 1 − erf((W − w)/(m + β W))/r,

with w the present energy of the virgin solid (β: Mars, as in Abaqus). With W held, the integral of
η dw is

    w + s/r [x erf x + (exp(−x²) − 1)/√π],   x = (W − w)/s,   s = m + β W,

and once w exceeds W it is w itself. So one incremental potential holds on both sides, and its
stress is continuous. Of the work put in, s₁/r [x₁ erf x₁ + (exp(−x₁²) − 1)/√π] with x₁ = W/s₁ does
not come back. It grows with W, so the dissipation is never negative.
"""

import math

import ufl
from ufl.core.expr import Expr


def _lost(x: Expr) -> Expr:
    """∫₀ˣ erf."""
    return x * ufl.erf(x) + (ufl.exp(-(x**2)) - 1) / math.sqrt(math.pi)


def energy(virgin: Expr, largest: Expr, inverse_r: Expr, m: Expr, beta: Expr) -> Expr:
    """The part that softening adds to a load step's potential per reference volume (mJ/mm³).

    Softening is given by 1/r, so that a solid which does not soften has 0. The energy is linear
    in it.

    Args:
        virgin: w at the step's end (mJ/mm³).
        largest: W at its start (mJ/mm³).
        inverse_r: 1/r, from 0 to 1; the stress falls by this part of itself at most.
        m: energy scale (MPa = mJ/mm³), above 0.
        beta: share of W in that scale.

    Example:
        Half-way back from W = 1 with m = ½ and r = 2 the stress falls by erf(1)/2 of itself.

        >>> from dolfingrip.forms.evaluate import number
        >>> w = ufl.variable(ufl.as_ufl(0.5))
        >>> round(number(ufl.diff(energy(w, 1.0, 0.5, 0.5, 0.0), w)), 6)
        -0.42135
    """
    scale = m + beta * largest
    behind = ufl.max_value(largest - virgin, 0) / scale
    return scale * inverse_r * _lost(behind)

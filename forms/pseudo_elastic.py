"""Mullins softening as a pseudo-elastic energy (Ogden & Roxburgh, Proc. R. Soc. A 455, 1999).

Below the largest energy W that a point has seen its stress is η times that of the virgin solid,

    η = 1 − erf((W − w)/(m + β W))/r,

with w the present energy of the virgin solid (β: Mars, as in Abaqus). With W held, η dw has the
integral

    w + s/r [x erf x + (exp(−x²) − 1)/√π],   x = (W − w)/s,   s = m + β W,

and it is w itself once w exceeds W: one incremental potential for both, with a continuous stress.
Of the work put in, s₁/r [x₁ erf x₁ + (exp(−x₁²) − 1)/√π] at x₁ = W/s₁ does not come back;
it grows with W, so that no dissipation is negative.
"""

import math

import ufl
from ufl.core.expr import Expr


def _lost(x: Expr) -> Expr:
    """∫₀ˣ erf."""
    return x * ufl.erf(x) + (ufl.exp(-(x**2)) - 1) / math.sqrt(math.pi)


def energy(virgin: Expr, largest: Expr, r: Expr, m: Expr, beta: Expr) -> Expr:
    """Incremental potential of a load step per reference volume (mJ/mm³).

    Args:
        virgin: w at the step's end (mJ/mm³).
        largest: W at its start (mJ/mm³).
        r: from 1 on; the softening is at most by 1/r.
        m: energy scale (MPa = mJ/mm³), above 0.
        beta: share of W in that scale.

    Example:
        Half-way back from W = 1 with m = ½ the stress is η = 1 − erf(1)/2 times the virgin one.

        >>> from dolfingrip.forms.evaluate import number
        >>> w = ufl.variable(ufl.as_ufl(0.5))
        >>> round(number(ufl.diff(energy(w, 1.0, 2.0, 0.5, 0.0), w)), 6)
        0.57865
    """
    scale = m + beta * largest
    behind = ufl.max_value(largest - virgin, 0) / scale
    return virgin + scale / r * _lost(behind)

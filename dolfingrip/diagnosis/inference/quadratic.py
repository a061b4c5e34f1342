"""Evidence of an effect whose change of the readings is quadratic in its strength.

The exponent of the integrand, a b·r + a² c·r − |a b + a² c|²/2 − (a − m)²/(2 s²), is a polynomial
of degree four, so its maxima are roots of a cubic. The integral is taken by Gauss–Legendre rules on
panels that are graded towards them.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from scipy.special import log_ndtr, logsumexp

from dolfingrip.diagnosis.inference.arrays import Vector

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
REACH = 12.0
"""Standard deviations of the prior within which strengths are looked for."""
GRADING = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Ends of panels on both sides of a maximum, in its widths."""


def log_bayes_factor(
    straight: Vector,
    curved: Vector,
    residual: Vector,
    mean: float,
    spread: float,
    one_sided: bool,
) -> tuple[float, float]:
    """ln BF against no effect, and the most probable strength.

    Args:
        straight, curved: b and c of the whitened change a b + a² c, shape (n,) each.
        residual: whitened, shape (n,).
        mean, spread: of the strength's normal prior.
        one_sided: whether only strengths above 0 are possible.
    """
    likelihood = Polynomial(
        [
            0.0,
            straight @ residual,
            curved @ residual - 0.5 * straight @ straight,
            -straight @ curved,
            -0.5 * curved @ curved,
        ]
    )
    exponent = likelihood - 0.5 * Polynomial([-mean / spread, 1 / spread]) ** 2
    low = 0.0 if one_sided else mean - REACH * spread
    high = max(mean, 0.0) + REACH * spread
    peaks = _maxima(exponent, low, high)
    panels = _panels(exponent, peaks, low, high)
    half = 0.5 * np.diff(panels)[:, None]
    points = (0.5 * (panels[:-1] + panels[1:]))[:, None] + half * NODES
    total = float(logsumexp(exponent(points), b=half * WEIGHTS))
    norm = np.log(spread) + 0.5 * np.log(2 * np.pi)
    norm += float(log_ndtr(mean / spread)) if one_sided else 0.0
    return total - norm, max(peaks, key=exponent)


def _maxima(exponent: Polynomial, low: float, high: float) -> list[float]:
    """Places of local maxima within [low, high]; its ends are among them."""
    roots = exponent.deriv().roots()
    real = roots[np.abs(roots.imag) < 1e-6 * (1 + np.abs(roots.real))].real
    return [low, high, *(float(x) for x in real if low < x < high)]


def _panels(exponent: Polynomial, peaks: list[float], low: float, high: float) -> Vector:
    slope, curvature = exponent.deriv(), exponent.deriv(2)
    ends = list(np.linspace(low, high, 25))
    for peak in peaks:
        rate = max(np.sqrt(max(-curvature(peak), 0.0)), abs(slope(peak)), 1 / (high - low))
        ends += [peak + side * step / rate for step in GRADING for side in (-1, 1)]
        ends.append(peak)
    return np.unique(np.clip(ends, low, high))

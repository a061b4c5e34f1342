"""Evidence of one effect whose change of the readings is linear in its strength: closed forms.

With whitened readings r and a whitened change w of length q, the score is z = (w/q)·r. The strength
a of the effect has the prior N(m, s²), or that cut at 0 for an effect that has one sign. Then

    BF = ∫ exp(a q z − a² q²/2) p(a) da

is the Bayes factor against no effect (Kass and Raftery 1995, J. Am. Stat. Assoc. 90:773). For m = 0
and τ = q s it is ln BF = −½ ln(1 + τ²) + ½ z² τ²/(1 + τ²).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import log_ndtr, ndtri, ndtri_exp

from dolfingrip.diagnosis.inference.arrays import Vector

INTERVAL = float(ndtri(0.95))
"""Half width of the central 90 % of a standard normal number."""
FAR = -50.0
"""Standard deviations beyond which a normal number that is cut is all but exponential."""


@dataclass(frozen=True)
class Amplitude:
    """What is known of an effect's strength after measuring, in units of its ordinary strength.

    Attributes:
        mean: expected value.
        std: standard deviation.
        low, high: ends of the central 90 %.
    """

    mean: float
    std: float
    low: float
    high: float


def log_bayes_factor(
    length: npt.ArrayLike,
    score: npt.ArrayLike,
    mean: npt.ArrayLike,
    spread: npt.ArrayLike,
    one_sided: npt.ArrayLike,
) -> Vector:
    """ln BF of an effect against none; all arguments broadcast against one another.

    Args:
        length: q, length of the whitened change at strength 1.
        score: z, the whitened residual along the change; of no account where q is 0.
        mean, spread: m and s of the strength's prior.
        one_sided: whether only strengths above 0 are possible.
    """
    q, z, m, s = (np.asarray(x, dtype=float) for x in (length, score, mean, spread))
    precision = q**2 + 1 / s**2
    centre = (q * z + m / s**2) / precision
    result = -0.5 * np.log1p((q * s) ** 2) + 0.5 * (centre**2 * precision - (m / s) ** 2)
    # tails cost most, so they are left out where both signs are possible
    cut = np.zeros(result.shape)
    one, after, before = np.broadcast_arrays(
        np.asarray(one_sided, dtype=bool), centre * np.sqrt(precision), log_ndtr(m / s)
    )
    cut[one] = log_ndtr(after[one]) - before[one]
    return np.asarray(result + cut)


def amplitude(
    length: float, score: float, mean: float, spread: float, one_sided: bool
) -> Amplitude:
    """The strength after measuring; arguments as those of :func:`log_bayes_factor`."""
    precision = length**2 + 1 / spread**2
    centre = (length * score + mean / spread**2) / precision
    std = precision**-0.5
    if not one_sided:
        return Amplitude(centre, std, centre - INTERVAL * std, centre + INTERVAL * std)
    # of a normal number cut at 0, by logarithms, which hold far out, too
    left = centre / std
    hazard = float(np.exp(-0.5 * left**2 - 0.5 * np.log(2 * np.pi) - log_ndtr(left)))
    variance = 1 - hazard * (hazard + left) if left > FAR else 1 / left**2
    low, high = (
        float(centre - std * ndtri_exp(np.log(1 - p) + log_ndtr(left))) for p in (0.05, 0.95)
    )
    return Amplitude(centre + std * hazard, std * float(np.sqrt(variance)), low, high)

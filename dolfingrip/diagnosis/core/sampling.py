"""Weighted draws of a density by adaptive importance sampling.

The first draws are of a multivariate t about the mode. Where few of them count, as on a curved
ridge, more are drawn about the mean of those before, with their covariance. For that mean their
weights are raised to a power that lets enough of them count (Koblents & Míguez, Stat. Comput. 25,
2015). Each draw is weighted against the mixture of all that were drawn from (Cornuet, Marin, Mira &
Robert, Scand. J. Stat. 39, 2012).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import scipy.stats
from scipy.special import logsumexp

from dolfingrip.diagnosis.policy import Policy

WIDER: Final = (1.0, 10.0)
"""Factors of the covariance that draws share: the wider ones find the ends of a ridge."""

EFFECTIVE: Final = 100
"""So many of the draws have to count as if they were alike in weight."""


def drawn(
    log_density: Callable[[np.ndarray], np.ndarray],
    mode: np.ndarray,
    covariance: np.ndarray,
    rng: np.random.Generator,
    policy: Policy = Policy(),
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Draws until enough of them count and the integral stays; None where too few ever do.

    Args:
        log_density: of places, shape (draws, d); −∞ where the density is 0.
        mode: shape (d,).
        covariance: about the mode, shape (d, d).
        rng: of the draws.
        policy: how many, and from what.

    Returns:
        The draws, shape (draws, d), their weights, whose sum is 1, and ln of the integral.
    """
    middle, spread = mode, covariance
    proposals, places = [], np.empty((0, len(mode)))
    densities, before = np.empty(0), np.inf
    for _ in range(2 * policy.tries):
        fresh = [
            scipy.stats.multivariate_t(middle, wider * _regular(spread), policy.freedom)
            for wider in WIDER
        ]
        proposals += fresh
        count = policy.draws // len(fresh)
        new = np.vstack([q.rvs(count, random_state=rng).reshape(count, len(mode)) for q in fresh])
        places, densities = np.vstack([places, new]), np.r_[densities, log_density(new)]
        mixture = logsumexp([q.logpdf(places) for q in proposals], axis=0)
        log = densities - (mixture - np.log(len(proposals)))
        if not np.isfinite(log.max()):
            return None
        total = float(logsumexp(log))
        weights, integral = np.exp(log - total), total - float(np.log(len(log)))
        alike, steady = 1 / np.square(weights).sum(), abs(integral - before) < policy.exactly
        if alike >= EFFECTIVE and (steady or alike > len(log) / 2):
            break
        before, least = integral, 2 * len(mode) + 2
        if np.isfinite(log).sum() < least:  # nearly all are where the density is 0
            continue
        tempered = _tempered(log, least)
        middle = tempered @ places
        spread = np.cov(places.T, aweights=tempered, ddof=0).reshape(spread.shape)
    return (places, weights, integral) if alike >= EFFECTIVE / 2 else None


def _tempered(log: np.ndarray, least: int) -> np.ndarray:
    """Weights raised to the largest power up to 1 by which so many draws count."""
    inside = np.isfinite(log)
    log = np.where(inside, log - log.max(), 0.0)  # a power of 0 leaves −∞ undefined
    low, high = 0.0, 1.0
    for _ in range(2 * 10):
        power = 0.5 * (low + high)
        weights = inside * np.exp(power * log)
        enough = weights.sum() ** 2 / (weights**2).sum() >= least
        low, high = (power, high) if enough else (low, power)
    weights = inside * np.exp(low * log)
    return np.asarray(weights / weights.sum())


def _regular(covariance: np.ndarray) -> np.ndarray:
    """The nearest covariance that rounding leaves positive definite."""
    sizes, ways = np.linalg.eigh(0.5 * (covariance + covariance.T))
    return np.asarray(ways * np.maximum(sizes, 1e-9 * sizes[-1]) @ ways.T)

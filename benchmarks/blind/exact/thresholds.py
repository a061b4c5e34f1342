"""Thresholds by simulation from the same covariance, so that false alarms are as rare as asked.

Parametric bootstrap: residuals are drawn from the hypothesis that a claim rejects, the statistic is
computed for each, and its upper quantile is the threshold.

No simulation is exact, so "no cause" is not a point but a neighbourhood (an interval null, Berger
and Delampady 1987, Stat. Sci. 2:317): an error of the simulation, or an effect, that changes all
readings together by :data:`UNSEEN` standard deviations is to raise no alarm more often than asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from benchmarks.blind.exact.pairs import Pairs
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector, unit
from dolfingrip.diagnosis.inference.posterior import LogPriors
from dolfingrip.diagnosis.inference.screen import Screen
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit

FALSE_ALARMS = 0.05
DRAWS = 1000
"""Thresholds of 400 scatter by 0.1."""
UNSEEN = 1.0
"""Length (σ) of a change of all readings that nobody can see. Simulations of the short finger with
hexahedra and with tetrahedra differ by 0.5 to 0.9 after nuisances, by protocol."""


@dataclass(frozen=True)
class Thresholds:
    """Log odds above which something is claimed.

    Attributes:
        something: against no cause.
        unknown: of an unknown cause against none and those of the catalogue.
    """

    something: float = 0.0
    unknown: float = 0.0


def calibrated_threshold(
    statistic: Callable[[Matrix], Vector],
    draw: Callable[[np.random.Generator, int], Matrix],
    level: float = FALSE_ALARMS,
    draws: int = DRAWS,
    seed: int = 0,
    bound: Callable[[Matrix], Vector] | None = None,
) -> float:
    """A threshold which the statistic exceeds with a probability of at most ``level``.

    Args:
        statistic: of samples of shape (n, draws), shape (draws,).
        draw: samples from the hypothesis that is rejected, shape (n, draws).
        level: probability of a false alarm, counted over the draws of the threshold, too.
        draws: how many.
        seed: of the random numbers.
        bound: an upper bound of the statistic that costs less; the statistic itself is then
            computed of as few samples as the quantile needs.

    Raises:
        ValueError: where there are too few draws for the level.
    """
    place = int(np.ceil((1 - level) * (draws + 1)))
    if place > draws:
        raise ValueError(f"draws = {draws}: allowed: at least {int(np.ceil(1 / level))}")
    samples = draw(np.random.default_rng(seed), draws)
    if bound is None:
        return float(np.sort(statistic(samples))[place - 1])
    return _largest(statistic, samples, bound(samples), draws - place + 1)


def _largest(
    statistic: Callable[[Matrix], Vector], samples: Matrix, bound: Vector, rank: int
) -> float:
    """The value of this rank from above, of samples (n, m) in the order of their bounds (m,)."""
    order = np.argsort(-bound)
    found: list[float] = []
    for start in range(0, len(order), rank):
        found += list(statistic(samples[:, order[start : start + rank]]))
        found = sorted(found, reverse=True)[:rank]
        left = order[start + rank :]
        if not len(left) or found[-1] >= bound[left[0]]:
            break
    return float(found[-1])


def of_analysis(
    screen: Screen,
    pairs: Pairs,
    unknown: SmoothMisfit,
    priors: LogPriors,
    level: float = FALSE_ALARMS,
    draws: int = DRAWS,
    seed: int = 0,
    unseen_sigma: float = UNSEEN,
) -> Thresholds:
    """Thresholds of both claims; never below even odds.

    "Something" is calibrated on residuals without a cause that can be seen. Its threshold is never
    below the odds before measuring either: readings that lower these do not speak for a cause.
    "Unknown" is calibrated on effects of the catalogue with strengths from their priors. Pairs are
    left out of the latter: they lower the odds of "unknown", so the threshold errs on the safe
    side.

    Args:
        screen, pairs, unknown, priors: of the analysis.
        level: probability of a false alarm.
        draws: residuals that are drawn for each.
        seed: of the random numbers.
        unseen_sigma: length of what the simulation may get wrong; 0 where it is known to be exact,
            and then odds below those before measuring may be a cause's.
    """
    before = priors.log_odds_something if unseen_sigma else 0.0

    def without(rng: np.random.Generator, count: int) -> Matrix:
        return draw_without_visible(screen, rng, count, unseen_sigma)

    def single(rng: np.random.Generator, count: int) -> Matrix:
        return rng.standard_normal((len(screen.covariance), count)) + _changes(screen, rng, count)

    def something_odds(whitened: Matrix) -> Vector:
        two = [np.logaddexp.reduce(pairs.scores(each).log_evidence) for each in whitened.T]
        return odds_with(whitened, np.array(two))

    def at_most(whitened: Matrix) -> Vector:
        return odds_with(whitened, np.array([pairs.log_sum_bound(each) for each in whitened.T]))

    def odds_with(whitened: Matrix, two: Vector) -> Vector:
        known, other = _totals(screen, unknown, priors, whitened)
        return np.asarray(logsumexp([known, other, priors.pair + two], axis=0) - priors.none)

    def unknown_odds(whitened: Matrix) -> Vector:
        known, other = _totals(screen, unknown, priors, whitened)
        return np.asarray(other - np.logaddexp(known, priors.none))

    something = calibrated_threshold(something_odds, without, level, draws, seed, at_most)
    other = calibrated_threshold(unknown_odds, single, level, draws, seed + 1)
    return Thresholds(something=max(0.0, before, something), unknown=max(0.0, other))


def draw_without_visible(
    screen: Screen, rng: np.random.Generator, count: int, unseen_sigma: float = UNSEEN
) -> Matrix:
    """Whitened residuals without a cause that can be seen, shape (n, count).

    Noise, and the change by a visible effect at a strength of ``unseen_sigma``: what a simulation
    gets wrong may look like any of them.
    """
    residuals = rng.standard_normal((len(screen.covariance), count))
    return residuals + unseen_sigma * unit(_changes(screen, rng, count))


def _changes(screen: Screen, rng: np.random.Generator, count: int) -> Matrix:
    """Whitened changes by single visible effects drawn from their priors, shape (n, count)."""
    visible = np.flatnonzero(screen.visible)
    if not len(visible):
        return np.zeros((len(screen.covariance), count))
    chosen = rng.choice(visible, count)
    return np.column_stack([screen.draw_change(int(i), rng) for i in chosen])


def _totals(
    screen: Screen, unknown: SmoothMisfit, priors: LogPriors, whitened: Matrix
) -> tuple[Vector, Vector]:
    """ln of prior times evidence of all single effects, and of unknown causes, per sample."""
    singles = logsumexp(
        np.vstack([priors.of_singles(screen.log_evidence(whitened)), _never(whitened)]), axis=0
    )
    beside = priors.of_beside(unknown.beside(screen, whitened))
    alone = priors.unknown + unknown.log_evidence(whitened)
    return np.asarray(singles), np.asarray(logsumexp(np.vstack([beside, alone]), axis=0))


def _never(whitened: Matrix) -> Matrix:
    """A row of −∞, so that a sum over no effect is 0."""
    return np.full((1, whitened.shape[1]), -np.inf)

"""Probabilities of all hypotheses: no cause, one, two, an unknown one alone or beside one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from benchmarks.blind.exact.pairs import PairScores
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.posterior import LogPriors


@dataclass(frozen=True, eq=False)
class Posterior:
    """Probabilities after measuring, sum 1.

    Attributes:
        none: of no cause that can be seen.
        singles: of each candidate alone, shape (candidates,).
        pairs: of two candidates, shape (candidates, candidates), upper triangle.
        unknown: of an unknown cause alone.
        beside: of each candidate beside an unknown cause, shape (candidates,).
    """

    none: float
    singles: Vector
    pairs: Matrix
    unknown: float
    beside: Vector

    @property
    def any_unknown(self) -> float:
        """Probability that there is an unknown cause."""
        return self.unknown + float(self.beside.sum())

    @property
    def at_most_one(self) -> float:
        """Probability that there is no cause, or one effect of the catalogue."""
        return self.none + float(self.singles.sum())

    def with_either(self, chosen: Sequence[int]) -> float:
        """Probability of catalogue hypotheses in which one of the chosen candidates takes part."""
        inside = np.zeros(len(self.singles), dtype=bool)
        inside[list(chosen)] = True
        touched = inside[:, None] | inside[None, :]
        return float(self.singles[inside].sum() + self.pairs[touched].sum())

    def with_both(self, first: Sequence[int], second: Sequence[int]) -> float:
        """Probability of pairs of one candidate of each group."""
        symmetric = self.pairs + self.pairs.T
        return float(symmetric[np.ix_(list(first), list(second))].sum())

    def log_odds_something(self) -> float:
        """ln of the odds that there is any cause."""
        return float(_log(1 - self.none) - _log(self.none))

    def log_odds_unknown(self) -> float:
        """ln of the odds of an unknown cause against none and those of the catalogue."""
        known = self.none + float(self.singles.sum() + self.pairs.sum())
        return float(_log(self.any_unknown) - _log(known))


def posterior(
    priors: LogPriors, singles: Vector, pairs: PairScores, unknown: float, beside: Vector
) -> tuple[Posterior, float]:
    """Probabilities from log Bayes factors against no cause, and ln of their average.

    Args:
        priors: of the hypotheses.
        singles, beside: shape (candidates,).
        pairs: of the visible candidates.
        unknown: of an unknown cause alone.
    """
    count = len(singles)
    joint = np.full((count, count), -np.inf)
    joint[pairs.members[:, 0], pairs.members[:, 1]] = priors.pair + pairs.log_evidence
    logs = np.concatenate(
        [
            [priors.none, priors.unknown + unknown],
            priors.of_singles(singles),
            priors.of_beside(beside),
            joint.ravel(),
        ]
    )
    total = float(logsumexp(logs))
    p = np.exp(logs - total)
    found = Posterior(
        none=float(p[0]),
        unknown=float(p[1]),
        singles=p[2 : 2 + count],
        beside=p[2 + count : 2 + 2 * count],
        pairs=p[2 + 2 * count :].reshape(count, count),
    )
    return found, total - priors.log_total


def mixed(posteriors: Sequence[Posterior], weights: Sequence[float]) -> Posterior:
    """The average over several models of the noise, with these probabilities (sum 1)."""
    both = list(zip(weights, posteriors, strict=True))
    return Posterior(
        none=sum(w * p.none for w, p in both),
        singles=np.sum([w * p.singles for w, p in both], axis=0),
        pairs=np.sum([w * p.pairs for w, p in both], axis=0),
        unknown=sum(w * p.unknown for w, p in both),
        beside=np.sum([w * p.beside for w, p in both], axis=0),
    )


def _log(x: float) -> float:
    return float(np.log(x)) if x > 0 else -np.inf

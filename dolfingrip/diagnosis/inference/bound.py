"""What is attainable: exact evidence with the true changes and the true covariance.

No method can name causes more often than the one that knows how each effect changes the readings,
how strong effects are and how noise and nuisances spread. A benchmark is held against this.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.candidate import Candidate
from dolfingrip.diagnosis.inference.classes import cosines, partition
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.screen import Screen

CLAIM = 0.9
"""Probability above which a class is claimed."""


@dataclass(frozen=True)
class Attainable:
    """Shares of hidden single effects.

    Attributes:
        effect_first: the true effect has the largest evidence.
        class_first: it is in the class of the one with the largest evidence.
        claimed: the leading class has more than :data:`CLAIM` probability.
        right_of_claimed: of these, the true effect is in it; NaN where nothing was claimed.
        draws: how many cases.
    """

    effect_first: float
    class_first: float
    claimed: float
    right_of_claimed: float
    draws: int


def exact_posterior(
    residual: Vector, candidates: Sequence[Candidate], covariance: Covariance, none: float = 0.0
) -> Vector:
    """Probability of no cause and of each candidate alone, shape (1 + candidates,), sum 1.

    Args:
        residual: shape (n,).
        candidates: with the true changes and the law that strengths were drawn from.
        covariance: the true one.
        none: weight of no cause by that of one candidate.
    """
    logs = Screen(candidates, covariance).log_evidence(covariance.whiten(residual)[:, None])[:, 0]
    first = np.log(none) if none > 0 else -np.inf
    return np.asarray(softmax(np.concatenate([[first], logs])))


def attainable(
    candidates: Sequence[Candidate],
    covariance: Covariance,
    draws: int,
    seed: int,
    strength_sigma: float | None = None,
) -> Attainable:
    """Hide single effects and name them by exact evidence.

    Args:
        candidates: each is hidden as often as the others; those that cannot be seen, too.
        covariance: of noise and nuisances.
        draws: how many cases.
        seed: of the random numbers.
        strength_sigma: length of the hidden change in standard deviations; drawn from the prior
            where None. Effects that change nothing are left out where it is given.
    """
    rng = np.random.default_rng(seed)
    screen = Screen(candidates, covariance)
    one_sided = np.array([candidate.one_sided for candidate in candidates], dtype=bool)
    length = np.array([screen.length[screen.owner == i].max() for i in range(len(candidates))])
    eligible = np.arange(len(candidates)) if strength_sigma is None else np.flatnonzero(length > 0)
    outcomes = np.zeros((draws, 4), dtype=bool)
    for draw in range(draws):
        true = int(rng.choice(eligible))
        change = screen.draw_change(true, rng)
        if strength_sigma is not None:
            change = change * strength_sigma / np.linalg.norm(change)
        scores = screen.scores(change + rng.standard_normal(len(covariance)))
        p = softmax([score.log_evidence for score in scores])
        first = int(p.argmax())
        cosine = cosines(scores, one_sided)
        groups = partition(cosine, scores[first].strength_sigma, range(len(candidates)))
        group = next(found for found in groups if first in found)
        claimed = float(p[list(group)].sum()) > CLAIM
        outcomes[draw] = (true == first, true in group, claimed, claimed and true in group)
    effect, of_class, claims, right = outcomes.mean(axis=0)
    return Attainable(
        effect_first=float(effect),
        class_first=float(of_class),
        claimed=float(claims),
        right_of_claimed=float(right / claims) if claims else float("nan"),
        draws=draws,
    )

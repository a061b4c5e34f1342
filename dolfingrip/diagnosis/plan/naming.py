"""Which effects readings could name, at which strength, and with which they are confused.

An effect of strength s (in standard deviations, nuisances fitted) makes the readings s u, u its
whitened change of length 1. There the evidence of each effect, of none and of an unknown smooth
cause is a closed form; the least s from which on the effect has probability :data:`CLAIM` is what
it takes to name it. With strengths a from the prior N(0, σ²) it is named in 2 Φ(−a₀/σ) of cases.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import logsumexp, ndtr

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.bound import CLAIM
from dolfingrip.diagnosis.inference.classes import TIED
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights, LogPriors
from dolfingrip.diagnosis.inference.screen import Screen
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit
from dolfingrip.diagnosis.plan.readings import Readings

STRENGTHS: Final = np.geomspace(1.0, 300.0, 80)
"""σ."""

LARGEST: Final = 5.0
"""Strengths of more standard deviations of the prior do not occur."""


@dataclass(frozen=True)
class Naming:
    """What the readings say about one effect.

    Attributes:
        effect: its name.
        ordinary: its parameters at the ordinary strength.
        strength_sigma: length of its change at the root mean square of the prior, nuisances fitted.
        named_from: least strength, by the ordinary one, from which on it is named alone; None where
            none that occurs is enough.
        named_from_sigma: the same in standard deviations.
        class_from: least strength from which on its class is named, by the ordinary one.
        share: probability that a strength from the prior is named alone.
        class_share: that its class is.
        confused_with: effects that cannot be told from it at the root mean square of the prior.
    """

    effect: str
    ordinary: str
    strength_sigma: float
    named_from: float | None
    named_from_sigma: float | None
    class_from: float | None
    share: float
    class_share: float
    confused_with: tuple[str, ...]


def namings(readings: Readings) -> list[Naming]:
    """Of each effect, the strongest first."""
    covariance = readings.covariance
    screen = Screen(readings.candidates, covariance)
    unknown = SmoothMisfit(readings.index, covariance, readings.noise_std)
    priors = LogPriors.of(HypothesisWeights(), screen.visible)
    found = [_naming(i, screen, unknown, priors) for i in range(len(screen.candidates))]
    return sorted(found, key=lambda each: -each.strength_sigma)


def share(found: Sequence[Naming]) -> float:
    """Part of the effects that is named, strengths from their priors."""
    return float(np.mean([each.share for each in found]))


def _naming(i: int, screen: Screen, unknown: SmoothMisfit, priors: LogPriors) -> Naming:
    candidate = screen.candidates[i]
    own = np.flatnonzero(screen.owner == i)
    first = int(own[0])
    length = float(screen.length[first])
    label = candidate.shapes[0].label
    spread = float(np.hypot(candidate.mean, candidate.spread))
    sigma = length * spread
    if not screen.visible[i] or length == 0:
        return Naming(candidate.name, label, sigma, None, None, None, 0.0, 0.0, ())
    direction: Vector = np.asarray(screen.columns[:, first] / length, dtype=float)
    cosines = _cosines(direction, screen, bool(candidate.one_sided))
    white = direction[:, None] * STRENGTHS
    logs = priors.of_singles(screen.log_evidence(white))
    others = np.vstack([np.full(len(STRENGTHS), priors.none),
                        priors.unknown + unknown.log_evidence(white)])  # fmt: skip
    total = logsumexp(np.vstack([logs, others]), axis=0)
    alone = np.exp(logs[i] - total)
    tied = 0.5 * STRENGTHS**2 * (1 - cosines[:, None] ** 2) < TIED
    tied[i] = True
    tied &= screen.visible[:, None]
    together = np.exp(logsumexp(np.where(tied, logs, -np.inf), axis=0) - total)
    named, of_class = _crossing(alone), _crossing(together)
    at_ordinary = 0.5 * sigma**2 * (1 - cosines**2) < TIED
    twins = [
        other.name
        for j, other in enumerate(screen.candidates)
        if j != i and at_ordinary[j] and screen.visible[j]
    ]
    return Naming(
        candidate.name, label, sigma,
        _within(named / length, spread),
        None if _within(named / length, spread) is None else named,
        _within(of_class / length, spread),
        _share(named / length, spread), _share(of_class / length, spread), tuple(twins),
    )  # fmt: skip


def _cosines(direction: Vector, screen: Screen, one_sided: bool) -> Vector:
    """Largest cosine with any shape of each candidate, of feasible sign, shape (candidates,)."""
    safe = np.where(screen.length > 0, screen.length, 1.0)
    gram = direction @ screen.columns / safe
    gram = np.where(one_sided & screen.one_sided, np.maximum(gram, 0.0), np.abs(gram))
    found = np.zeros(len(screen.candidates))
    np.maximum.at(found, screen.owner, gram)
    return found


def _crossing(probability: Vector) -> float:
    """Least strength (σ) from which on the probability stays above the claim; infinite if never."""
    below = np.flatnonzero(probability < CLAIM)
    if not below.size:
        return float(STRENGTHS[0])
    last = int(below[-1])
    if last + 1 == len(STRENGTHS):
        return math.inf
    return float(np.exp(np.interp(CLAIM, probability[last : last + 2],
                                  np.log(STRENGTHS[last : last + 2]))))  # fmt: skip


def _within(strength: float, spread: float) -> float | None:
    return strength if strength <= LARGEST * spread else None


def _share(strength: float, spread: float) -> float:
    return float(2 * ndtr(-strength / spread)) if math.isfinite(strength) else 0.0

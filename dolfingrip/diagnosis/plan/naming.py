"""Which effects readings could name, at which strength, and with which they are confused.

An effect of strength s (in standard deviations, nuisances fitted) makes the readings s u, u its
whitened change of length 1. There the evidence of each effect, of none and of an unknown smooth
cause is a closed form; the least s from which on the effect has probability :data:`CLAIM` is what
it takes to name it. The share of cases in which it is named is the prior's mass of such strengths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import logsumexp, ndtr

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.candidate import Candidate
from dolfingrip.diagnosis.inference.classes import TIED
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights, LogPriors
from dolfingrip.diagnosis.inference.screen import Screen
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit
from dolfingrip.diagnosis.plan.readings import Readings

CLAIM: Final = 0.9
"""Probability above which an effect or a class is claimed."""

STRENGTHS: Final = np.geomspace(1.0, 300.0, 80)
"""σ."""

LARGEST: Final = 5.0
"""Strengths of so many times the root mean square of the prior do not occur."""


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


def share_of_classes(found: Sequence[Naming]) -> float:
    """Part of the effects whose class is named."""
    return float(np.mean([each.class_share for each in found]))


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
    strengths: Vector = np.asarray(STRENGTHS / length, dtype=float)
    occurs = strengths <= LARGEST * spread
    named, of_class = (
        _least(strengths[occurs], probability[occurs]) for probability in (alone, together)
    )
    at_ordinary = 0.5 * sigma**2 * (1 - cosines**2) < TIED
    twins = [
        other.name
        for j, other in enumerate(screen.candidates)
        if j != i and at_ordinary[j] and screen.visible[j]
    ]
    mass = _mass(strengths, candidate)
    return Naming(
        candidate.name, label, sigma, named, None if named is None else named * length, of_class,
        float(mass @ (alone >= CLAIM)), float(mass @ (together >= CLAIM)), tuple(twins),
    )  # fmt: skip


def _cosines(direction: Vector, screen: Screen, one_sided: bool) -> Vector:
    """Largest cosine with any shape of each candidate, of feasible sign, shape (candidates,)."""
    safe = np.where(screen.length > 0, screen.length, 1.0)
    gram = direction @ screen.columns / safe
    gram = np.where(one_sided & screen.one_sided, np.maximum(gram, 0.0), np.abs(gram))
    found = np.zeros(len(screen.candidates))
    np.maximum.at(found, screen.owner, gram)
    return found


def _least(strengths: Vector, probability: Vector) -> float | None:
    """Least strength that is claimed, interpolated; None if none is."""
    above = np.flatnonzero(probability >= CLAIM)
    if not above.size:
        return None
    first = int(above[0])
    if first == 0:
        return float(strengths[0])
    pair = slice(first - 1, first + 1)
    return float(np.exp(np.interp(CLAIM, probability[pair], np.log(strengths[pair]))))


def _mass(strengths: Vector, candidate: Candidate) -> Vector:
    """Prior probability of a strength about each of these, of either sign where it may have."""
    edges = np.sqrt(strengths[1:] * strengths[:-1])

    def below(size: Vector) -> Vector:
        up = ndtr((size - candidate.mean) / candidate.spread)
        down = ndtr((-size - candidate.mean) / candidate.spread)
        if not candidate.one_sided:
            return np.asarray(up - down)
        start = ndtr(-candidate.mean / candidate.spread)
        return np.asarray((up - start) / (1 - start))

    return np.diff(np.concatenate([[below(strengths[:1])[0]], below(edges), [1.0]]))

"""The verdict from fits: probabilities of all hypotheses, fitted ones by their own evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np

from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.analysis import FREE, Analysis
from dolfingrip.diagnosis.inference.arrays import Vector, unit
from dolfingrip.diagnosis.inference.pairs import PairScores
from dolfingrip.diagnosis.inference.posterior import Posterior, mixed, posterior
from dolfingrip.diagnosis.inference.screen import Score, Screen
from dolfingrip.diagnosis.inference.thresholds import Thresholds
from dolfingrip.diagnosis.inference.verdict import Verdict, decide
from dolfingrip.diagnosis.problem import Problem

Fits = Mapping[frozenset[str], Hypothesis]
"""By the names of the effects; none of them is the base model."""

NONE: Final[frozenset[str]] = frozenset()
PAIR: Final = 2

KEPT: Final = 64
"""Fits that are judged once, of the many times that a search asks for all probabilities."""


@dataclass(frozen=True, eq=False)
class Conclusion:
    """What the readings say under one model of the noise.

    Attributes:
        problem: with that noise.
        analysis: screen and unknown causes, with nuisances and modulus about the base fit.
        posterior: probabilities of all hypotheses.
        scores: of the candidates, by their fits where there are.
        pairs: evidence of each pair of visible candidates.
        log_density: ln of the readings' density, averaged over all hypotheses.
    """

    problem: Problem
    analysis: Analysis
    posterior: Posterior
    scores: tuple[Score, ...]
    pairs: PairScores
    log_density: float

    def verdict(self, thresholds: Thresholds, other: Posterior | None = None) -> Verdict:
        """With this posterior or another with the same scores."""
        return decide(
            other or self.posterior, self.analysis.screen, self.scores, self.pairs, thresholds
        )


def screen(problem: Problem, none: Hypothesis, left_out: Sequence[str] = ()) -> Analysis:
    """Candidates and covariance about the base model's fit."""
    candidates = Screen(problem.candidates(left_out), none.covariance(problem))
    return Analysis(problem.index, candidates, problem.noise_std)


def conclude(problem: Problem, analysis: Analysis, fits: Fits) -> Conclusion:
    """Probabilities of all hypotheses.

    Args:
        problem: with the noise.
        analysis: made by :func:`screen` with the same noise.
        fits: that of no effect is among them.
    """
    none = fits[NONE]
    residual = none.residual(problem.value)
    findings = analysis.findings(residual)
    names = [candidate.name for candidate in analysis.screen.candidates]
    reference = none.log_evidence(problem)
    singles = np.array([score.log_evidence for score in findings.scores])
    one = findings.whitened[:, None]
    beside = analysis.unknown.beside(analysis.screen, one)[:, 0]
    evidence: dict[tuple[int, int], float] = {
        (int(e), int(f)): float(log)
        for (e, f), log in zip(findings.pairs.members, findings.pairs.log_evidence, strict=True)
    }
    fitted = {name for key in fits if len(key) == 1 for name in key}
    for i, name in enumerate(names):
        if name not in fitted:
            continue
        singles[i], unknown, second = _judged(problem, analysis, fits[frozenset([name])])
        singles[i] -= reference
        beside[i] = singles[i] + unknown
        for key in evidence:
            if i in key:
                other = key[0] if key[1] == i else key[1]
                own = singles[i] + float(second[other])
                known = names[other] in fitted and other < i
                evidence[key] = max(evidence[key], own) if known else own
    for effects, fit in fits.items():
        if len(effects) == PAIR:
            e, f = sorted(names.index(name) for name in effects)
            # larger noise may hide an effect that was fitted under another
            if (e, f) in evidence:
                evidence[e, f] = fit.log_evidence(problem) - reference
    if fitted:  # two effects that are far from the truth alone are judged by no tangent
        for key in evidence:
            if not fitted & {names[key[0]], names[key[1]]}:
                evidence[key] = -np.inf
    pairs = replace(findings.pairs, log_evidence=np.array(list(evidence.values())))
    found, log_mean = posterior(
        analysis.priors, singles, pairs, float(analysis.unknown.log_evidence(one)[0]), beside
    )
    scores = _scores(problem, analysis, fits, findings.scores, singles)
    return Conclusion(problem, analysis, found, scores, pairs, reference + log_mean)


@lru_cache(maxsize=KEPT)
def _judged(problem: Problem, analysis: Analysis, fit: Hypothesis) -> tuple[float, float, Vector]:
    """ln evidence of a fit, and what an unknown cause and each candidate add beside it."""
    covariance = fit.covariance(problem)
    left = covariance.whiten(fit.residual(problem.value))[:, None]
    unknown = float(analysis.unknown.under(covariance).log_evidence(left)[0])
    second = Screen(analysis.screen.candidates, covariance).log_evidence(left)[:, 0]
    return fit.log_evidence(problem), unknown, second


def _scores(
    problem: Problem,
    analysis: Analysis,
    fits: Fits,
    scores: Sequence[Score],
    singles: Vector,
) -> tuple[Score, ...]:
    """Evidence, direction and strength of the fits, the modulus left free."""
    none = fits[NONE]
    free = none.widened(problem, FREE)
    found = []
    for i, score in enumerate(scores):
        key = frozenset([score.name])
        if key in fits:
            change = fits[key].readings - none.readings
        else:
            shape = analysis.screen.candidates[i].shapes[score.shape]
            change = score.amplitude.mean * shape.change
        white = free.whiten(change)
        length = float(np.linalg.norm(white))
        found.append(
            replace(
                score,
                log_evidence=float(singles[i]),
                strength_sigma=length,
                direction=unit(white),
            )
        )
    return tuple(found)


def averaged(
    conclusions: Mapping[str, Conclusion], prior: Mapping[str, float]
) -> tuple[Posterior, dict[str, float]]:
    """Probabilities averaged over models of the noise, and those of the models."""
    names = list(conclusions)
    logs = np.array([conclusions[k].log_density + np.log(prior[k]) for k in names])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    return (
        mixed([conclusions[k].posterior for k in names], [float(w) for w in weights]),
        dict(zip(names, map(float, weights), strict=True)),
    )

"""Which hypotheses are fitted nonlinearly, one after the other, until the leading one is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from dolfingrip.diagnosis.conclude import NONE, Conclusion, conclude
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.analysis import Analysis
from dolfingrip.diagnosis.inference.posterior import LogPriors
from dolfingrip.diagnosis.inference.screen import Score
from dolfingrip.diagnosis.model import coupons_alone
from dolfingrip.diagnosis.remodulated import remodulated
from dolfingrip.diagnosis.surface import SurfacePoint

SINGLES: Final = 3
"""Leading effects that are fitted."""

MORE: Final = 3
"""Further effects, where one that was not fitted would lead."""

PAIRS: Final = 2
"""Pairs that are fitted, where they would lead."""

PART: Final = 0.8
"""An effect that explains less than this part of what the leading one does is not fitted, …"""

BEHIND: Final = 12.0
"""… if its log evidence is this much smaller, too."""

CERTAINLY_NONE: Final = 0.9
"""Probability of no cause in the screen from which on nothing is fitted."""

WORTH: Final = 0.01
"""Probability that a hypothesis needs to be worth a fit after the leading ones."""

OFF: Final = 0.25
"""Part of its change by which an effect is supposed to be off the surface between the screen's
simulations, at most; where the leading effect is off its own by more, twice that."""

LEAVES: Final = 3.0
"""Standard deviations of χ² within which a fit leaves nothing but noise."""


@dataclass
class _Search:
    """What is fitted, and what was tried."""

    fitter: Fitter
    analysis: Analysis
    fits: dict[frozenset[str], Hypothesis]
    scores: dict[str, Score]
    tried: set[frozenset[str]] = field(default_factory=set)

    @property
    def names(self) -> list[str]:
        """Of the candidates, in their order."""
        return [candidate.name for candidate in self.analysis.screen.candidates]

    def conclusion(self) -> Conclusion:
        """From what is fitted so far."""
        return conclude(self.fitter.problem, self.analysis, self.fits)

    def attempt(self, key: frozenset[str]) -> None:
        """Fit a hypothesis, unless it is outrun."""
        self.tried.add(key)
        if len(key) == 1 and self._outrun(next(iter(key))):
            return
        problem = self.fitter.problem
        best = max(self.fits.values(), key=lambda fit: fit.log_evidence(problem))
        scores = [self.scores[name] for name in self.names if name in key]
        found = self.fitter.effects(scores, self.fits, best if best.effects else None)
        if found is not None:
            self.fits[key] = found

    def _point(self, name: str) -> SurfacePoint | None:
        return self.fitter.on_surface(self.scores[name], self.fits[NONE])

    def _outrun(self, name: str) -> bool:
        """Whether an effect stays far behind one whose fit leaves nothing but noise.

        Its best place between the simulations of the screen tells what it leaves. To make that up,
        it would have to be off there by a larger part of its own change than effects are.
        """
        problem = self.fitter.problem
        point = self._point(name)
        alone = [fit for key, fit in self.fits.items() if len(key) == 1]
        if point is None or not alone:
            return False
        best = max(alone, key=lambda fit: fit.log_evidence(problem))
        behind = best.log_evidence(problem) - point.log_evidence
        left = best.covariance(problem).whiten(best.residual(problem.value))
        n = len(left)
        if float(left @ left) > n + LEAVES * math.sqrt(2 * n) or behind < BEHIND:
            return False
        off = max(OFF, 2 * self._off(best))
        change = float(np.linalg.norm(problem.covariance.whiten(point.change)))
        return math.sqrt(2 * behind) > off * change

    def _off(self, fit: Hypothesis) -> float:
        """By which part of its change a fitted effect is off its surface."""
        (name,) = fit.effects
        point = self._point(name)
        if point is None:
            return 0.0
        problem = self.fitter.problem
        lost = max(fit.log_evidence(problem) - point.log_evidence, 0.0)
        change = float(np.linalg.norm(problem.covariance.whiten(point.change)))
        return math.sqrt(2 * lost) / max(change, 1e-300)


def search(
    fitter: Fitter, analysis: Analysis, none: Hypothesis
) -> dict[frozenset[str], Hypothesis]:
    """Fits of the base model, the leading effects and pairs, by the names of their effects."""
    fits = {NONE: none}
    first = conclude(fitter.problem, analysis, fits)
    fits |= remodulated(fitter, first.scores, none)
    tried = set(fits) - {NONE}
    if tried:
        first = conclude(fitter.problem, analysis, fits)
    if first.posterior.none > CERTAINLY_NONE:
        return fits
    own = _Search(fitter, analysis, fits, {score.name: score for score in first.scores}, tried)
    for name in _leading(first)[:SINGLES]:
        own.attempt(frozenset([name]))
    for _ in range(MORE):
        best = _best_single(own.conclusion(), own.names)
        if best is None or frozenset([best]) in own.tried:
            break
        own.attempt(frozenset([best]))
    for _ in range(PAIRS):
        pair = _best_pair(own.conclusion(), analysis.priors, own.names)
        if pair is None or pair in own.tried:
            break
        own.attempt(pair)
    if coupons_alone(fitter.problem.measurement):  # which are simulated in no time
        for name in _leading(own.conclusion()):
            if frozenset([name]) not in own.tried:
                own.attempt(frozenset([name]))
    return fits


def _leading(conclusion: Conclusion) -> list[str]:
    """Effects in the order of what they explain, alone or in a pair."""
    found = conclusion.posterior
    scores = conclusion.scores
    visible = [i for i, score in enumerate(scores) if score.visible]
    if not visible:
        return []
    best = max(scores[i].log_evidence for i in visible)
    worth = [
        i
        for i in visible
        if scores[i].log_evidence > min(PART * best, best - BEHIND)
        or found.with_either([i]) > WORTH
    ]
    return [
        scores[i].name
        for i in sorted(worth, key=lambda i: (found.with_either([i]), scores[i].log_evidence))[::-1]
    ]


def _best_single(conclusion: Conclusion, names: Sequence[str]) -> str | None:
    """The most probable effect that takes part in a hypothesis of one."""
    singles = conclusion.posterior.singles + conclusion.posterior.beside
    if not len(singles) or singles.max() < WORTH:
        return None
    return names[int(singles.argmax())]


def _best_pair(
    conclusion: Conclusion, priors: LogPriors, names: Sequence[str]
) -> frozenset[str] | None:
    """The most probable pair, where it is more so than any effect alone.

    An unknown cause does not count here. Beside one fitted effect, a strong second one is judged
    by its secant, which an unknown cause outdoes by far; only the fit tells.
    """
    logs = conclusion.pairs.log_evidence
    if not len(logs):
        return None
    alone = priors.of_singles(np.array([score.log_evidence for score in conclusion.scores])).max()
    best = int(logs.argmax())
    if priors.pair + logs[best] < max(alone, priors.none + np.log(WORTH)):
        return None
    return frozenset(names[int(i)] for i in conclusion.pairs.members[best])

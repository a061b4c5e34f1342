"""Which hypotheses are fitted nonlinearly, one after the other, until the leading one is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from dolfingrip.diagnosis.conclude import NONE, Conclusion, conclude
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.analysis import Analysis
from dolfingrip.diagnosis.inference.posterior import LogPriors

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


def search(
    fitter: Fitter, analysis: Analysis, none: Hypothesis
) -> dict[frozenset[str], Hypothesis]:
    """Fits of the base model, the leading effects and pairs, by the names of their effects."""
    problem = fitter.problem
    fits = {NONE: none}
    first = conclude(problem, analysis, fits)
    if first.posterior.none > CERTAINLY_NONE:
        return fits
    scores = {score.name: score for score in first.scores}
    names = [candidate.name for candidate in analysis.screen.candidates]
    tried: set[frozenset[str]] = set()

    def attempt(key: frozenset[str]) -> None:
        tried.add(key)
        found = fitter.effects([scores[name] for name in names if name in key], none)
        if found is not None:
            fits[key] = found

    for name in _leading(first)[:SINGLES]:
        attempt(frozenset([name]))
    for _ in range(MORE):
        best = _best_single(conclude(problem, analysis, fits), names)
        if best is None or frozenset([best]) in tried:
            break
        attempt(frozenset([best]))
    for _ in range(PAIRS):
        pair = _best_pair(conclude(problem, analysis, fits), analysis.priors, names)
        if pair is None or pair in tried:
            break
        attempt(pair)
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

"""How far an answer hangs on the priors: other odds of two causes, wider priors of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dolfingrip.diagnosis.core.decision import Decision, decide, held
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.policy import POLICY


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Answers under other priors.

    Attributes:
        answers: by what is other about the priors, that of the policy's own priors first.
        probability: of the policy's answer under each: of one member of each of its sets.
    """

    answers: Mapping[str, Decision]
    probability: Mapping[str, float]

    @property
    def least(self) -> float:
        """The smallest of these probabilities."""
        return min(self.probability.values())


OWN = "as told"


def sensitivity(posterior: Posterior) -> tuple[Decision, Sensitivity]:
    """The answer, and what it is under other priors.

    A second cause is named only where it is more probable than not under each of them.
    """
    variants = {
        OWN: posterior,
        "two causes a third as likely": _reweighted(
            posterior, _pairs_by(posterior, 1 / POLICY.pairs_by)
        ),
        "two causes three times as likely": _reweighted(
            posterior, _pairs_by(posterior, POLICY.pairs_by)
        ),
        "priors twice as wide": _reweighted(
            posterior, [_wider(fit, posterior.case.own) for fit in posterior.fits]
        ),
    }
    answers = {name: decide(each) for name, each in variants.items()}
    decision = answers[OWN]
    if decision.second and min(_of(each, decision) for each in answers.values()) <= POLICY.likelier:
        decision = decide(posterior, single=True)
    return decision, Sensitivity(
        answers, {name: _of(each, decision) for name, each in answers.items()}
    )


def _of(other: Decision, decision: Decision) -> float:
    """Probability of an answer by other probabilities."""
    if decision.answer == "none":
        return other.none
    if decision.answer == "unknown":
        return other.discrepancy if decision.nearest else other.unknown
    return min(held(other.subsets, decision.first, decision.second), 1 - other.unexplained)


def _pairs_by(posterior: Posterior, factor: float) -> list[float]:
    causes = posterior.case.causes
    return [np.log(factor) if len(causes(fit.subset)) == 2 else 0.0 for fit in posterior.fits]


def _wider(fit: Fit, first: int) -> float:
    """Change of ln evidence where the priors of the causes' numbers are twice as wide (Laplace)."""
    d = len(fit.zeta)
    if d == first:
        return 0.0
    own = np.r_[np.zeros(first), np.ones(d - first)]
    relaxed = fit.hessian - 0.75 * np.diag(own)
    pull = own * fit.zeta
    # the numbers follow where the prior pulls less
    gain = 0.5 * 0.75 * float(pull @ pull)
    gain += 0.5 * 0.75**2 * float(pull @ np.linalg.solve(relaxed, pull))
    determinants = np.linalg.slogdet(relaxed)[1] - np.linalg.slogdet(fit.hessian)[1]
    return gain - (d - first) * float(np.log(2)) - 0.5 * float(determinants)


def _reweighted(posterior: Posterior, logs: Sequence[float]) -> Posterior:
    with np.errstate(divide="ignore"):
        total = np.log(posterior.probability) + np.asarray(logs)
    weights = np.exp(total - total.max())
    return replace(posterior, probability=weights / weights.sum())

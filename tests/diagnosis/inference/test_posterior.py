"""Probabilities before measuring: those of all hypotheses are 1 in sum, shared as weights say."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest

from dolfingrip.diagnosis.inference.pairs import PairScores
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights, LogPriors, posterior


@pytest.mark.parametrize("count", [1, 2, 5, 30])
def test_priors_of_all_hypotheses_are_the_weights(count: int) -> None:
    weights = HypothesisWeights(none=0.2, single=0.4, pair=0.3, unknown=0.1)
    visible = np.append(np.ones(count, dtype=bool), False)
    priors = LogPriors.of(weights, visible)
    pairs = comb(count, 2)
    sums = {
        "none": np.exp(priors.none),
        "single": count * np.exp(priors.single),
        "pair": pairs * np.exp(priors.pair),
        "unknown": np.exp(priors.unknown) + count * np.exp(priors.beside),
    }
    told = {"none": 0.2, "single": 0.4, "pair": 0.3 if pairs else 0.0, "unknown": 0.1}
    assert sums == pytest.approx(told)
    assert sum(sums.values()) == pytest.approx(np.exp(priors.log_total))
    odds = (sum(told.values()) - 0.2) / 0.2
    assert priors.log_odds_something == pytest.approx(np.log(odds))


def test_readings_that_tell_nothing_leave_the_priors() -> None:
    """All Bayes factors are 1; what cannot be seen has no probability."""
    weights = HypothesisWeights()
    priors = LogPriors.of(weights, np.array([True, True, False, True]))
    members = np.array([[0, 1], [0, 3], [1, 3]])
    found, log_mean = posterior(
        priors, np.zeros(4), PairScores(members, np.zeros(3), np.zeros((3, 2))), 0.0, np.zeros(4)
    )
    assert found.none == pytest.approx(weights.none)
    assert found.singles == pytest.approx(weights.single / 3 * np.array([1, 1, 0, 1]))
    assert [found.pairs[i, k] for i, k in members] == pytest.approx([weights.pair / 3] * 3)
    assert found.pairs.sum() == pytest.approx(weights.pair)
    assert found.any_unknown == pytest.approx(weights.unknown)
    assert found.unknown == pytest.approx(found.beside.sum())
    assert log_mean == pytest.approx(0.0)


def test_without_candidates_none_and_unknown_share_all() -> None:
    priors = LogPriors.of(HypothesisWeights(), np.zeros(0, dtype=bool))
    none = PairScores(np.zeros((0, 2), dtype=int), np.zeros(0), np.zeros((0, 2)))
    found, _ = posterior(priors, np.zeros(0), none, 0.0, np.zeros(0))
    assert (found.none, found.unknown) == pytest.approx((0.25 / 0.4, 0.15 / 0.4))

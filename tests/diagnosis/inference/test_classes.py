"""Classes and thresholds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.classes import (
    cosines,
    cosines_beside,
    partition,
    separation,
)
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.screen import Screen
from dolfingrip.diagnosis.inference.thresholds import calibrated_threshold


def test_separation_is_the_loss_of_the_best_fit_by_the_other() -> None:
    # reference: least squares of one change by the other
    rng = np.random.default_rng(50)
    v, w = rng.normal(size=(2, 9))
    left = v - w * (v @ w) / (w @ w)
    cosine = v @ w / np.linalg.norm(v) / np.linalg.norm(w)
    assert separation(np.linalg.norm(v), cosine) == pytest.approx(0.5 * left @ left)


def test_ties_are_joined_through_third_ones() -> None:
    angle = np.array([0.0, 20.0, 40.0, 90.0]) * np.pi / 180
    cosine = np.cos(angle[:, None] - angle[None, :])
    # at 6 σ: 20° leave 2.1, 40° 7.4, ln 20 is 3.0
    assert partition(cosine, 6.0, range(4)) == [(0, 1, 2), (3,)]
    assert partition(cosine, 6.0, [0, 2, 3]) == [(0,), (2,), (3,)]
    assert partition(cosine, 20.0, range(4)) == [(0,), (1,), (2,), (3,)]
    assert partition(cosine, 20.0, []) == []


def test_opposite_changes_are_tied_only_where_signs_are_free() -> None:
    v = np.array([1.0, 2.0, 3.0])
    for one_sided, expected in ((True, 0.0), (False, 1.0)):
        pair = [
            Candidate(name, (Shape(sign * v),), 1.0, 0.5, one_sided)
            for name, sign in (("a", 1), ("b", -1))
        ]
        scores = Screen(pair, Covariance.of(np.eye(3))).scores(2 * v)
        found = cosines(scores, np.array([one_sided, one_sided]))
        assert found[0, 1] == pytest.approx(expected)


def test_beside_a_third_effect_two_can_become_alike() -> None:
    # reference: angles after the third is projected off (its strength is all but free)
    rng = np.random.default_rng(51)
    v = rng.normal(size=(3, 6))
    free = [Candidate(name, (Shape(x),)) for name, x in zip("abc", v, strict=True)]
    scores = Screen(free, Covariance.of(np.eye(6))).scores(v.sum(axis=0))
    found = cosines_beside(scores, np.zeros(3, dtype=bool), 2, 1e6)
    left = v[:2] - np.outer(v[:2] @ v[2], v[2]) / (v[2] @ v[2])
    expected = abs(left[0] @ left[1]) / np.linalg.norm(left[0]) / np.linalg.norm(left[1])
    assert found[0, 1] == pytest.approx(expected, rel=1e-6)


def test_a_threshold_keeps_its_level() -> None:
    # reference: the normal quantile; the mean rate over thresholds of independent seeds is 5 %
    def draw(rng: np.random.Generator, count: int) -> np.ndarray:
        return rng.normal(size=(3, count))

    found = [calibrated_threshold(lambda x: x[1], draw, 0.05, 199, seed) for seed in range(300)]
    assert norm.sf(found).mean() == pytest.approx(0.05, abs=0.003)
    assert calibrated_threshold(lambda x: x[1], draw, 0.05, 199, 4) == found[4]
    with pytest.raises(ValueError, match="draws = 10: allowed: at least 20"):
        calibrated_threshold(lambda x: x[1], draw, 0.05, 10)
    # with a bound it is the same, of few samples where the bound is close
    for slack, few in ((0.0, 10), (0.2, 60), (10.0, 199)):
        asked = []

        def statistic(x: np.ndarray, asked: list[int] = asked) -> np.ndarray:
            asked.append(x.shape[1])
            return np.asarray(x[1])

        def bound(x: np.ndarray, slack: float = slack) -> np.ndarray:
            return np.asarray(x[1] + slack * np.abs(x[2]))

        assert calibrated_threshold(statistic, draw, 0.05, 199, 4, bound) == found[4]
        assert sum(asked) <= few

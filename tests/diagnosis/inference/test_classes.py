"""Classes of effects that readings cannot tell apart."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.classes import (
    cosines,
    cosines_beside,
    partition,
    separation,
)
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.screen import Screen


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

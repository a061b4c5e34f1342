"""The blind benchmark: evidence of causes whose change is quadratic in their strength."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.inference import synthetic
from scipy.stats import norm

from benchmarks.blind import curved
from benchmarks.blind.curved import CurvedScreen, CurvedShape
from dolfingrip.diagnosis.inference.candidate import Candidate
from dolfingrip.diagnosis.inference.evidence import log_bayes_factor

TABLE = synthetic.index()
COVARIANCE = synthetic.covariance(TABLE)
LOAD = synthetic.load(TABLE)
FORCE = np.where(synthetic.is_angle(TABLE), 0.0, 0.02)


def screen(spread: float) -> tuple[np.ndarray, np.ndarray, CurvedScreen]:
    """b, c, and a cause whose secant at half the strength is told, too."""
    b, c = 15 * FORCE * np.sin(5 * LOAD), -30 * FORCE * np.sin(5 * LOAD + 0.6)
    shape = CurvedShape(b + c, second=(0.5, 0.5 * b + 0.25 * c))
    candidate = Candidate("mooney_rivlin", (shape,), 1.0, spread, True)
    return b, c, CurvedScreen([candidate], COVARIANCE)


def test_a_change_passes_through_both_secants() -> None:
    one, half = np.array([1.0, 2.0, 3.0]), np.array([0.4, 1.5, 1.0])
    b, c = CurvedShape(one, second=(0.5, half)).polynomial()
    assert b + c == pytest.approx(one)
    assert 0.5 * b + 0.25 * c == pytest.approx(half)


@pytest.mark.parametrize("one_sided", [True, False])
@pytest.mark.parametrize("size", [1.0, 300.0])
def test_quadratic_evidence(one_sided: bool, size: float) -> None:
    # reference: a trapezoid of 2 million points; the second size has a peak 1/300 wide
    rng = np.random.default_rng(3)
    b, c = size * rng.normal(size=4), 0.3 * size * rng.normal(size=4)
    r = 0.8 * b + 0.64 * c + rng.normal(size=4)
    a = np.linspace(0 if one_sided else -7, 8, 2_000_001)
    d = np.outer(b, a) + np.outer(c, a**2)
    logs = r @ d - 0.5 * (d**2).sum(axis=0) + norm.logpdf(a, 1.0, 0.5)
    peak = logs.max()
    expected = peak + np.log(np.trapezoid(np.exp(logs - peak), a))
    expected -= norm.logcdf(2.0) if one_sided else 0.0
    found, best = curved.log_bayes_factor(b, c, r, 1.0, 0.5, one_sided)
    assert found == pytest.approx(expected, abs=1e-6)
    assert best == pytest.approx(a[logs.argmax()], abs=1e-4)


def test_a_straight_quadratic_is_the_closed_form() -> None:
    rng = np.random.default_rng(4)
    b, r = 40 * rng.normal(size=7), 30 * rng.normal(size=7)
    q = np.linalg.norm(b)
    found, _ = curved.log_bayes_factor(b, np.zeros(7), r, 1.0, 0.4, True)
    assert found == pytest.approx(log_bayes_factor(q, b @ r / q, 1.0, 0.4, True), abs=1e-8)


def test_the_strength_is_recovered() -> None:
    b, c, own = screen(0.5)
    r = 1.36 * b + 1.36**2 * c
    found = own.scores(COVARIANCE.whiten(r))[0]
    assert found.amplitude.mean == pytest.approx(1.36, abs=0.02)
    assert found.amplitude.low < 1.36 < found.amplitude.high
    assert found.strength_sigma == pytest.approx(np.linalg.norm(COVARIANCE.whiten(r)), rel=0.02)


def test_drawn_changes_lie_on_the_curve() -> None:
    b, c, own = screen(0.4)
    both = COVARIANCE.whiten(np.column_stack([b, c]))
    for seed in range(5):
        drawn = own.draw_change(0, np.random.default_rng(seed))
        (one, square), left, *_ = np.linalg.lstsq(both, drawn, rcond=None)
        assert left.sum() < 1e-18
        assert square == pytest.approx(one**2)

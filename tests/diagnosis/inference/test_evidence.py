"""Closed forms of evidence, against quadrature and direct normal densities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm, truncnorm

from dolfingrip.diagnosis.inference import quadratic
from dolfingrip.diagnosis.inference.arrays import log_mean_exp
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.evidence import (
    amplitude,
    log_bayes_factor,
    log_bayes_factor_together,
)


def test_two_sided_is_the_ratio_of_normal_densities() -> None:
    # reference: N(r; m w, 1 + s² w wᵀ) / N(r; 0, 1)
    rng = np.random.default_rng(1)
    w, r, mean, spread = rng.normal(size=5), rng.normal(size=5), 0.7, 1.3
    q = np.linalg.norm(w)
    effect = multivariate_normal(mean * w, np.eye(5) + spread**2 * np.outer(w, w)).logpdf(r)
    none = multivariate_normal(np.zeros(5), np.eye(5)).logpdf(r)
    found = log_bayes_factor(q, w @ r / q, mean, spread, False)
    assert found == pytest.approx(effect - none, abs=1e-10)


@pytest.mark.parametrize("score", [-6.0, 0.3, 7.0])
@pytest.mark.parametrize("mean", [0.0, 1.0, -0.4])
def test_one_sided_is_the_integral_over_positive_strengths(score: float, mean: float) -> None:
    # reference: adaptive quadrature of the likelihood ratio times the cut prior
    q, spread = 2.5, 0.6
    inside, _ = quad(
        lambda a: np.exp(a * q * score - 0.5 * (a * q) ** 2) * norm.pdf(a, mean, spread),
        0, 8, points=[max(score / q, 0.0)], epsabs=0, epsrel=1e-11,
    )  # fmt: skip
    expected = np.log(inside / norm.sf(0, mean, spread))
    assert log_bayes_factor(q, score, mean, spread, True) == pytest.approx(expected, abs=1e-8)


def test_the_formula_with_mean_zero() -> None:
    # reference: −½ ln(1+τ²) + ½ z²τ²/(1+τ²) + ln 2Φ(zτ/√(1+τ²))
    q, z, spread = 3.0, -1.2, 0.5
    tau = q * spread
    expected = -0.5 * np.log(1 + tau**2) + 0.5 * z**2 * tau**2 / (1 + tau**2)
    assert log_bayes_factor(q, z, 0, spread, False) == pytest.approx(expected)
    expected += np.log(2 * norm.cdf(z * tau / np.sqrt(1 + tau**2)))
    assert log_bayes_factor(q, z, 0, spread, True) == pytest.approx(expected)


def test_what_changes_nothing_has_no_evidence_and_far_scores_stay_finite() -> None:
    assert log_bayes_factor(0.0, 0.0, 1.0, 0.5, True) == pytest.approx(0.0, abs=1e-12)
    assert np.isfinite(log_bayes_factor(700.0, -900.0, 1.0, 0.3, True))
    assert log_mean_exp([-1000.0, -1000.0]) == pytest.approx(-1000.0)


@pytest.mark.parametrize(("score", "one_sided"), [(2.0, True), (-8.0, True), (2.0, False)])
def test_strength_after_measuring(score: float, one_sided: bool) -> None:
    # reference: scipy's truncated normal law of the closed-form posterior
    q, mean, spread = 3.0, 1.0, 0.5
    centre, std = (q * score + mean / spread**2) / (q**2 + 4), (q**2 + 4) ** -0.5
    law = truncnorm(-centre / std, np.inf, centre, std) if one_sided else norm(centre, std)
    found = amplitude(q, score, mean, spread, one_sided)
    assert found.mean == pytest.approx(law.mean(), rel=1e-6)
    assert found.std == pytest.approx(law.std(), rel=1e-4)
    assert (found.low, found.high) == pytest.approx(tuple(law.ppf([0.05, 0.95])), rel=1e-6)


def test_several_together() -> None:
    rng = np.random.default_rng(2)
    w, r = rng.normal(size=(6, 3)), rng.normal(size=6)
    mean, spread = np.array([0.5, 0.0, -1.0]), np.array([0.3, 2.0, 1.0])
    widened = np.eye(6) + (w * spread**2) @ w.T
    expected = multivariate_normal(w @ mean, widened).logpdf(r)
    expected -= multivariate_normal(np.zeros(6), np.eye(6)).logpdf(r)
    assert log_bayes_factor_together(w, r, mean, spread) == pytest.approx(expected, abs=1e-10)


def test_a_quadratic_change_passes_through_both_secants() -> None:
    one, half = np.array([1.0, 2.0, 3.0]), np.array([0.4, 1.5, 1.0])
    shape = Shape(one, second=(0.5, half))
    assert shape.at_strength(1.0) == pytest.approx(one)
    assert shape.at_strength(0.5) == pytest.approx(half)
    assert shape.at_strength(0.0) == pytest.approx(np.zeros(3))


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
    found, best = quadratic.log_bayes_factor(b, c, r, 1.0, 0.5, one_sided)
    assert found == pytest.approx(expected, abs=1e-6)
    assert best == pytest.approx(a[logs.argmax()], abs=1e-4)


def test_a_straight_quadratic_is_the_closed_form() -> None:
    rng = np.random.default_rng(4)
    b, r = 40 * rng.normal(size=7), 30 * rng.normal(size=7)
    q = np.linalg.norm(b)
    found, _ = quadratic.log_bayes_factor(b, np.zeros(7), r, 1.0, 0.4, True)
    assert found == pytest.approx(log_bayes_factor(q, b @ r / q, 1.0, 0.4, True), abs=1e-8)


def test_bad_candidates_are_told() -> None:
    with pytest.raises(ValueError, match="spread = 0"):
        Candidate("prony", (Shape(np.ones(2)),), spread=0)
    with pytest.raises(ValueError, match="second strength = 1"):
        Candidate("prony", (Shape(np.ones(2), second=(1.0, np.ones(2))),))
    with pytest.raises(ValueError, match="prony: has no shape"):
        Candidate("prony", ())

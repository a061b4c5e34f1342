"""Closed forms of evidence, against quadrature and direct normal densities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm, truncnorm

from dolfingrip.diagnosis.inference.arrays import log_mean_exp
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.evidence import amplitude, log_bayes_factor


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


def test_bad_candidates_are_told() -> None:
    with pytest.raises(ValueError, match="spread = 0"):
        Candidate("prony", (Shape(np.ones(2)),), spread=0)
    with pytest.raises(ValueError, match="prony: has no shape"):
        Candidate("prony", ())

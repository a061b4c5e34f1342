"""Evidence of two effects together, and the probability that both are positive."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.inference import synthetic
from scipy.integrate import dblquad
from scipy.special import log_ndtr
from scipy.stats import multivariate_normal

from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.orthant import log_both_positive
from dolfingrip.diagnosis.inference.pairs import Pairs
from dolfingrip.diagnosis.inference.screen import Screen


def test_both_positive_near_the_middle() -> None:
    # reference: scipy's bivariate normal distribution function (Genz), to 1e-8 or so
    rng = np.random.default_rng(5)
    mean = rng.normal(size=(30, 2))
    root = rng.normal(size=(30, 2, 2))
    covariance = root @ root.transpose(0, 2, 1) + 0.01 * np.eye(2)
    expected = [
        np.log(multivariate_normal(-m, c).cdf([0, 0]))
        for m, c in zip(mean, covariance, strict=True)
    ]
    assert log_both_positive(mean, covariance) == pytest.approx(np.array(expected), abs=1e-5)


def test_both_positive_far_out_and_nearly_dependent() -> None:
    # references: independent numbers; two that are all but the same number; Sheppard's formula
    far = np.array([[-30.0, -20.0], [3.0, -40.0]])
    found = log_both_positive(far, np.array([np.eye(2)] * 2))
    assert found == pytest.approx(log_ndtr(far).sum(axis=1), abs=1e-8)
    same = np.array([[1.0, 1 - 1e-8], [1 - 1e-8, 1.0]])
    assert log_both_positive(np.array([[-12.0, -3.0]]), same[None]) == pytest.approx(
        log_ndtr(-12.0), abs=1e-4
    )
    rho = np.array([-0.999, -0.3, 0.6, 0.99999])
    covariance = np.array([[[1, x], [x, 1]] for x in rho])
    expected = np.log(0.25 + np.arcsin(rho) / (2 * np.pi))
    assert log_both_positive(np.zeros((4, 2)), covariance) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("sided", [(True, True), (True, False), (False, False)])
def test_a_pair_is_the_double_integral(sided: tuple[bool, bool]) -> None:
    # reference: adaptive quadrature over both strengths
    rng = np.random.default_rng(6)
    v = rng.normal(size=(2, 4))
    candidates = [
        Candidate(name, (Shape(v[k]),), mean=0.5 * k, spread=0.8, one_sided=sided[k])
        for k, name in enumerate(("a", "b"))
    ]
    matrix = 0.5 * np.eye(4) + 0.2
    covariance = Covariance.of(matrix)
    r = rng.normal(size=4)
    inverse = np.linalg.inv(matrix)

    def integrand(b: float, a: float) -> float:
        d = a * v[0] + b * v[1]
        prior = np.exp(-0.5 * (a / 0.8) ** 2 - 0.5 * ((b - 0.5) / 0.8) ** 2) / (2 * np.pi * 0.64)
        return float(np.exp(d @ inverse @ r - 0.5 * d @ inverse @ d) * prior)

    low = [0.0 if each else -6.0 for each in sided]
    value, _ = dblquad(integrand, low[0], 6, low[1], 7, epsrel=1e-9)
    expected = np.log(value)
    expected -= log_ndtr(0.0) if sided[0] else 0.0
    expected -= log_ndtr(0.5 / 0.8) if sided[1] else 0.0
    scores = Pairs(Screen(candidates, covariance)).scores(covariance.whiten(r))
    assert scores.log_evidence[0] == pytest.approx(expected, abs=1e-7)


def test_a_pair_of_shapes_is_averaged_over_all_combinations() -> None:
    # reference: normal densities with each combination by itself
    rng = np.random.default_rng(7)
    shapes = [[Shape(rng.normal(size=5)) for _ in range(count)] for count in (2, 3)]
    candidates = [Candidate(name, tuple(s)) for name, s in zip("ab", shapes, strict=True)]
    covariance = Covariance.of(np.eye(5))
    r = rng.normal(size=5)
    none = multivariate_normal(np.zeros(5), np.eye(5)).logpdf(r)
    one = [
        multivariate_normal(
            np.zeros(5), np.eye(5) + np.outer(a.change, a.change) + np.outer(b.change, b.change)
        ).logpdf(r)
        - none
        for a in shapes[0]
        for b in shapes[1]
    ]
    scores = Pairs(Screen(candidates, covariance)).scores(r)
    assert scores.log_evidence[0] == pytest.approx(np.log(np.mean(np.exp(one))))


def test_the_sum_over_pairs_is_below_its_bound() -> None:
    # exact where strengths may have both signs
    rng = np.random.default_rng(8)
    covariance = Covariance.of(np.eye(6))
    for sided in (False, True):
        candidates = [
            Candidate(name, tuple(Shape(x) for x in rng.normal(size=(2, 6))), one_sided=sided)
            for name in "abcd"
        ]
        pairs = Pairs(Screen(candidates, covariance))
        for r in 2 * rng.normal(size=(20, 6)):
            total = np.logaddexp.reduce(pairs.scores(r).log_evidence)
            bound = pairs.log_sum_bound(r)
            assert total <= bound + 1e-9
            assert sided or bound == pytest.approx(total, abs=1e-9)


def test_two_hidden_effects_are_found_together() -> None:
    analysis = synthetic.analysis()
    change = synthetic.columns(analysis.index)
    for one, other in (("plate_friction", "hardening"), ("set", "plate_tilt")):
        verdict = synthetic.verdict(analysis, change[one] + change[other])
        assert verdict.answer == "cause"
        assert len(verdict.named) == 2
        assert {one, other} <= set(verdict.names)
        assert "together with" in verdict.sentence()

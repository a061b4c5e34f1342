"""Evidence and intervals at a fit: exact where they must be, near quadrature elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

from dolfingrip.diagnosis.descent import Visited, descend
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.model import FreeParameter
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.extensions.effect import Prior

PRESSURE = np.linspace(0.1, 1.0, 12)


def free(*priors: Prior) -> tuple[FreeParameter, ...]:
    return tuple(FreeParameter("test", each, -np.inf, np.inf) for each in priors)


def problem(value: np.ndarray, std: float) -> Problem:
    covariance = Covariance.of(std**2 * np.eye(len(value)))
    return cast(Problem, SimpleNamespace(value=value, covariance=covariance))


def at(place: Visited, parameters: tuple[FreeParameter, ...]) -> Hypothesis:
    return Hypothesis(("test",), parameters, place.zeta, place.readings, place.jacobian)


def test_a_linear_model_is_exact() -> None:
    # reference: normal density of the data with the parameters integrated out
    rng = np.random.default_rng(9)
    columns, y, std = rng.normal(size=(8, 2)), rng.normal(size=8), 0.5
    mean, spread = np.array([1.0, -2.0]), np.array([0.4, 1.5])
    priors = [Prior(m, s, "test") for m, s in zip(mean, spread, strict=True)]
    told, own = problem(y, std), free(*priors)
    ended = descend(
        lambda a: (columns @ np.array(a), columns), own, y, told.covariance, [1.0, -2.0], 1e-12, 20
    )
    found = at(ended.last, own)
    widened = std**2 * np.eye(8) + (columns * spread**2) @ columns.T
    expected = multivariate_normal(columns @ mean, widened).logpdf(y)
    assert found.log_evidence(told) == pytest.approx(expected, abs=1e-6)
    information = columns.T @ columns / std**2 + np.diag(1 / spread**2)
    exact = np.linalg.solve(information, columns.T @ y / std**2 + mean / spread**2)
    half = 1.6448536 * np.sqrt(np.diag(np.linalg.inv(information)))
    for k, estimate in enumerate(found.estimates(told)):
        assert estimate.value == pytest.approx(exact[k], abs=1e-5)
        assert (estimate.low, estimate.high) == pytest.approx(
            (exact[k] - half[k], exact[k] + half[k]), abs=1e-4
        )


def test_a_nonlinear_one_is_near_quadrature() -> None:
    # reference: adaptive quadrature over the one parameter's ζ
    prior = Prior(1.0, 0.5, "test", positive=True)
    std = 0.05
    y = np.exp(-1.4 * PRESSURE) + std * np.random.default_rng(10).normal(size=12)
    told = problem(y, std)

    def evaluate(values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        readings = np.exp(-values[0] * PRESSURE)
        return readings, (-PRESSURE * readings)[:, None]

    own = free(prior)
    found = at(descend(evaluate, own, y, told.covariance, [0.9], 1e-12, 30).last, own)

    def density(zeta: float) -> float:
        left = y - evaluate([prior.at(zeta)])[0]
        return float(np.exp(told.covariance.log_density(left) - 20) * norm.pdf(zeta))

    peak = float(found.zeta[0])
    integral, _ = quad(density, peak - 3, peak + 3, points=[peak], epsrel=1e-9)
    assert found.log_evidence(told) == pytest.approx(np.log(integral) + 20, abs=0.02)
    (estimate,) = found.estimates(told)
    inside, _ = quad(density, prior.zeta(estimate.low), prior.zeta(estimate.high))
    assert inside / integral == pytest.approx(0.9, abs=0.01)
    assert estimate.low < 1.4 < estimate.high


def test_a_parameter_that_readings_do_not_tell_keeps_its_prior() -> None:
    own = free(Prior(2.0, 0.4, "test", positive=True))
    found = at(Visited(np.zeros(1), np.zeros(4), np.zeros((4, 1))), own)
    told = problem(np.ones(4), 1.0)
    assert found.estimates(told)[0].std_by_prior == pytest.approx(1.0)
    assert found.log_evidence(told) == pytest.approx(norm.logpdf(1.0) * 4)


def test_log_normal_numbers_have_the_prior_mean_and_spread() -> None:
    # reference: moments of 200,000 draws
    prior = Prior(0.6, 0.2, "test", positive=True)
    zeta = np.random.default_rng(11).normal(size=200_000)
    values = np.array([prior.at(z) for z in zeta])
    assert values.mean() == pytest.approx(0.6, rel=0.005)
    assert values.std() == pytest.approx(0.2, rel=0.02)
    assert prior.zeta(prior.at(0.7)) == pytest.approx(0.7)
    with pytest.raises(ValueError, match="value = -1"):
        prior.zeta(-1.0)

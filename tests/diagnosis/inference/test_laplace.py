"""Laplace's evidence: exact where it must be, near quadrature elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

from dolfingrip.diagnosis.inference.laplace import fit, to_value, to_zeta
from dolfingrip.extensions.effect import Prior

PRESSURE = np.linspace(0.1, 1.0, 12)


def test_a_linear_model_is_exact() -> None:
    # reference: normal density of the data with the parameters integrated out
    rng = np.random.default_rng(9)
    columns, y, std = rng.normal(size=(8, 2)), rng.normal(size=8), 0.5
    priors = [Prior(1.0, 0.4, "test"), Prior(-2.0, 1.5, "test")]
    mean, spread = np.array([1.0, -2.0]), np.array([0.4, 1.5])
    found = fit(lambda a: (y - columns @ np.array(a)) / std, priors, 8 * np.log(std**2))
    covariance = std**2 * np.eye(8) + (columns * spread**2) @ columns.T
    expected = multivariate_normal(columns @ mean, covariance).logpdf(y)
    assert found.log_evidence == pytest.approx(expected, abs=1e-6)
    information = columns.T @ columns / std**2 + np.diag(1 / spread**2)
    exact = np.linalg.solve(information, columns.T @ y / std**2 + mean / spread**2)
    half = 1.6448536 * np.sqrt(np.diag(np.linalg.inv(information)))
    for k, estimate in enumerate(found.estimates):
        assert estimate.value == pytest.approx(exact[k], abs=1e-5)
        assert (estimate.low, estimate.high) == pytest.approx(
            (exact[k] - half[k], exact[k] + half[k]), abs=1e-4
        )


@pytest.mark.parametrize("given", [True, False])
def test_a_nonlinear_one_is_near_quadrature(given: bool) -> None:
    # reference: adaptive quadrature over the one parameter's ζ
    prior = Prior(1.0, 0.5, "test", positive=True)
    std = 0.05
    y = np.exp(-1.4 * PRESSURE) + std * np.random.default_rng(10).normal(size=12)

    def residual(values: Sequence[float]) -> np.ndarray:
        return (y - np.exp(-values[0] * PRESSURE)) / std

    def jacobian(values: Sequence[float]) -> np.ndarray:
        return (PRESSURE * np.exp(-values[0] * PRESSURE) / std)[:, None]

    logdet = 12 * np.log(std**2)
    found = fit(residual, [prior], logdet, jacobian=jacobian if given else None)

    def density(zeta: float) -> float:
        w = residual([to_value(prior, zeta)])
        return float(np.exp(-0.5 * w @ w + 20) * norm.pdf(zeta))

    peak = float(found.zeta[0])
    integral, _ = quad(density, peak - 3, peak + 3, points=[peak], epsrel=1e-9)
    expected = np.log(integral) - 20 - 0.5 * (logdet + 12 * np.log(2 * np.pi))
    assert found.log_evidence == pytest.approx(expected, abs=0.02)
    estimate = found.estimates[0]
    inside, _ = quad(density, to_zeta(prior, estimate.low), to_zeta(prior, estimate.high))
    assert inside / integral == pytest.approx(0.9, abs=0.01)
    assert estimate.low < 1.4 < estimate.high


def test_a_parameter_that_readings_do_not_tell_keeps_its_prior() -> None:
    prior = Prior(2.0, 0.4, "test", positive=True)
    found = fit(lambda values: np.ones(4), [prior], 0.0)
    assert found.estimates[0].std_by_prior == pytest.approx(1.0)
    assert found.log_evidence == pytest.approx(norm.logpdf(1.0) * 4)


def test_log_normal_numbers_have_the_prior_mean_and_spread() -> None:
    # reference: moments of 200,000 draws
    prior = Prior(0.6, 0.2, "test", positive=True)
    zeta = np.random.default_rng(11).normal(size=200_000)
    values = np.array([to_value(prior, z) for z in zeta])
    assert values.mean() == pytest.approx(0.6, rel=0.005)
    assert values.std() == pytest.approx(0.2, rel=0.02)
    assert to_zeta(prior, to_value(prior, 0.7)) == pytest.approx(0.7)
    with pytest.raises(ValueError, match="value = -1"):
        to_zeta(prior, -1.0)

"""Unknown causes: closed forms against direct normal densities."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.inference import synthetic
from scipy.linalg import LinAlgError, eigh, svd
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from dolfingrip.diagnosis.inference import unknown
from dolfingrip.diagnosis.inference.screen import Screen
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit

TABLE = synthetic.index(specimens=2, cycles=2, points=4)
COVARIANCE = synthetic.covariance(TABLE)
MISFIT = SmoothMisfit(TABLE, COVARIANCE, synthetic.noise_std(TABLE), sizes=(1.0, 8.0))


def processes() -> list[np.ndarray]:
    """Covariances of all processes on the grid, unwhitened."""
    factor = COVARIANCE.factor
    return [
        factor @ (system.vectors * system.values * size**2) @ system.vectors.T @ factor.T
        for system in MISFIT.systems
        for size in MISFIT.sizes
    ]


def test_evidence_alone_is_the_average_of_normal_densities() -> None:
    r = COVARIANCE.sample(np.random.default_rng(15), 1)[:, 0]
    r += 2 * synthetic.noise_std(TABLE) * np.sin(4 * synthetic.load(TABLE))
    zero = np.zeros(len(r))
    logs = [multivariate_normal(zero, COVARIANCE.matrix + k).logpdf(r) for k in processes()]
    expected = logsumexp(logs) - np.log(len(logs)) - COVARIANCE.log_density(r)
    found = MISFIT.log_evidence(COVARIANCE.whiten(r)[:, None])[0]
    assert found == pytest.approx(expected, abs=1e-6)


def test_evidence_beside_an_effect_is_that_of_both() -> None:
    r = COVARIANCE.sample(np.random.default_rng(16), 1)[:, 0]
    candidate = synthetic.candidates(TABLE)[2]
    candidate = type(candidate)("hardening", candidate.shapes, 0.3, 0.5)
    v = candidate.shapes[0].change
    logs = [
        multivariate_normal(0.3 * v, COVARIANCE.matrix + k + 0.25 * np.outer(v, v)).logpdf(r)
        for k in processes()
    ]
    expected = logsumexp(logs) - np.log(len(logs)) - COVARIANCE.log_density(r)
    screen = Screen([candidate], COVARIANCE)
    found = MISFIT.beside(screen, COVARIANCE.whiten(r)[:, None])[0, 0]
    assert found == pytest.approx(expected, abs=1e-6)


def test_the_process_is_common_to_specimens_and_separate_by_channel() -> None:
    # system 0: all channels, full likeness between branches and cycles, the shortest length
    kernel = processes()[0]
    angle = synthetic.is_angle(TABLE)
    first = (TABLE["specimen"] == "finger 0").to_numpy()
    assert kernel[np.ix_(first, first)] == pytest.approx(kernel[np.ix_(first, ~first)], abs=1e-4)
    assert np.abs(kernel[np.ix_(angle, ~angle)]).max() < 1e-10
    assert np.diag(kernel)[angle] == pytest.approx(0.09, rel=1e-4)
    # reference: the squared exponential of the distance in load
    i, j = np.flatnonzero(angle & first)[:2]
    assert kernel[i, j] == pytest.approx(0.09 * np.exp(-0.5 * (1 / 3 / 0.15) ** 2), rel=1e-2)


def test_readings_on_hold_are_smooth_in_the_logarithm_of_time() -> None:
    table = TABLE.copy()
    table.loc[table["branch"] == "unloading", "branch"] = "hold"
    misfit = SmoothMisfit(table, COVARIANCE, synthetic.noise_std(table))
    assert np.isfinite(misfit.log_evidence(np.ones((len(table), 1)))[0])


@pytest.mark.parametrize("features", [5, 60])
def test_systems_are_singular_vectors_and_values_of_their_features(features: int) -> None:
    """With fewer features than readings, and with more. Reference: scipy's decomposition."""
    matrix = np.random.default_rng(3).normal(size=(30, features))
    system = unknown.decomposed(matrix, (1.0,))
    vectors, singular, _ = svd(matrix, full_matrices=False)
    assert system.values == pytest.approx(singular**2, rel=1e-9)
    same = np.abs(np.sum(system.vectors * vectors, axis=0))
    assert same == pytest.approx(1.0, abs=1e-9)


def test_a_decomposition_that_does_not_converge_is_done_another_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """LAPACK's quicker driver fails for some matrices; which, depends on its build."""
    matrix = np.random.default_rng(6).normal(size=(30, 8))
    expected = unknown.decomposed(matrix, (1.0,))

    def only_slowly(values: np.ndarray, driver: str = "evr") -> tuple[np.ndarray, np.ndarray]:
        if driver == "evr":
            raise LinAlgError("internal error")
        return eigh(values, driver=driver)

    monkeypatch.setattr(unknown, "eigh", only_slowly)
    found = unknown.decomposed(matrix, (1.0,))
    assert found.values == pytest.approx(expected.values, rel=1e-9)
    same = np.abs(np.sum(found.vectors * expected.vectors, axis=0))
    assert same == pytest.approx(1.0, abs=1e-9)


def test_unknown_causes_under_another_covariance_are_those_prepared_for_it() -> None:
    columns = np.random.default_rng(4).normal(size=(len(TABLE), 2))
    wider = COVARIANCE.widened(columns)
    residual = np.random.default_rng(5).normal(size=(len(TABLE), 3))
    fresh = SmoothMisfit(TABLE, wider, synthetic.noise_std(TABLE), sizes=(1.0, 8.0))
    before = MISFIT.log_evidence(residual)
    found = MISFIT.under(wider).log_evidence(residual)
    assert found == pytest.approx(fresh.log_evidence(residual), rel=1e-12)
    assert MISFIT.log_evidence(residual) == pytest.approx(before, rel=0)  # it is left as it was
    assert found != pytest.approx(before, rel=1e-3)

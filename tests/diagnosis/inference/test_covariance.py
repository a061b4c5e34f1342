"""Covariance, noise and readings."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.inference import synthetic
from scipy.stats import multivariate_normal

from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise, noise_matrix
from dolfingrip.diagnosis.inference.readings import load, tracks


def test_density_and_whitening_are_those_of_the_normal_law() -> None:
    # reference: scipy's multivariate normal density
    rng = np.random.default_rng(8)
    root = rng.normal(size=(6, 6))
    matrix = root @ root.T + np.eye(6)
    covariance, r = Covariance.of(matrix), rng.normal(size=6)
    assert covariance.log_density(r) == pytest.approx(
        multivariate_normal(np.zeros(6), matrix).logpdf(r)
    )
    drawn = covariance.sample(rng, 40_000)
    assert np.cov(drawn) == pytest.approx(matrix, abs=0.06 * matrix.max())
    column = rng.normal(size=6)
    assert covariance.widened(column).matrix == pytest.approx(matrix + np.outer(column, column))


def test_a_covariance_that_is_not_positive_is_told() -> None:
    with pytest.raises(ValueError, match="not positive definite"):
        Covariance.of(np.zeros((3, 3)))


def test_noise_is_correlated_along_a_run_alone() -> None:
    table = synthetic.index(specimens=2, points=3)
    noise = {
        "angle_deg": ChannelNoise(0.3, correlated_std=0.4, length=25.0, offset_std=0.1),
        "force_N": ChannelNoise(0.02, drift_std=0.05),
    }
    matrix = noise_matrix(table, noise)
    angle, force = (table["channel"] == name for name in ("angle_deg", "force_N"))
    first = (table["specimen"] == "finger 0").to_numpy()
    assert not matrix[np.ix_(angle, force)].any()
    assert not matrix[np.ix_(first, ~first)].any()
    i, j = np.flatnonzero(angle)[[0, 2]]  # 20 s apart
    assert matrix[i, j] == pytest.approx(0.16 * np.exp(-20 / 25) + 0.01)
    assert matrix[i, i] == pytest.approx(0.09 + 0.16 + 0.01)
    last = np.flatnonzero(force & first)[-1]
    assert matrix[last, last] == pytest.approx(0.02**2 + 0.05**2)
    shuffled = table.sample(frac=1.0, random_state=3)
    order = shuffled.index.to_numpy()
    assert noise_matrix(shuffled, noise) == pytest.approx(matrix[np.ix_(order, order)])


def test_bad_noise_is_told() -> None:
    table = synthetic.index(points=3)
    with pytest.raises(ValueError, match="noise std = 0"):
        ChannelNoise(0.0)
    with pytest.raises(ValueError, match="noise of force_N is not given; given: angle_deg"):
        noise_matrix(table, {"angle_deg": ChannelNoise(0.3)})


def test_load_and_tracks() -> None:
    table = synthetic.index(points=3)
    assert load(table).tolist() == [0, 0.5, 1, 1, 0.5, 0] * 2
    coupon = table.assign(pressure_kPa=np.nan, displacement_mm=np.arange(12.0) % 6)
    assert load(coupon).max() == 1
    assert [len(rows) for rows in tracks(table)] == [6, 6]

"""The significance table and the sentences that are made of it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from diagnosis.inference import synthetic

from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.multiple import holm
from dolfingrip.diagnosis.inference.noise import noise_matrix
from dolfingrip.diagnosis.inference.sentences import sentences
from dolfingrip.diagnosis.inference.significance import significance_table

TABLE = synthetic.index(points=21)
NOISE = noise_matrix(TABLE, synthetic.NOISE)
COVARIANCE = synthetic.covariance(TABLE)
BASE = synthetic.base(TABLE)
EDGES = (0.0, 100.0, 175.0, 250.0)


def table_of(residual: np.ndarray, index: pd.DataFrame = TABLE) -> pd.DataFrame:
    noise = noise_matrix(index, synthetic.NOISE)
    plain = Covariance.of(noise)
    base = synthetic.base(index)
    return significance_table(index, base + residual, residual, noise, plain, EDGES)


def test_holm() -> None:
    # reference: by hand, 3 × .01, 2 × .03, 1 × .04 made monotonic
    assert holm([0.04, 0.01, 0.03]).tolist() == pytest.approx([0.06, 0.03, 0.06])


def test_errors_are_those_of_the_mean_under_the_whole_covariance() -> None:
    # reference: scatter of the means of 20,000 draws
    rng = np.random.default_rng(40)
    drawn = COVARIANCE.sample(rng, 20_000)
    found = significance_table(TABLE, BASE, drawn[:, 0], NOISE, COVARIANCE, EDGES)
    row = found[(found["channel"] == "force_N") & (found["by"] == "pressure")].iloc[1]
    pressure = TABLE["pressure_kPa"]
    chosen = ~synthetic.is_angle(TABLE) & ((pressure > 100) & (pressure <= 175)).to_numpy()
    means = drawn[chosen].mean(axis=0)
    assert row["count"] == chosen.sum()
    assert row["simulated_minus_measured"] == pytest.approx(-means[0])
    assert row["std_error"] == pytest.approx(means.std(), rel=0.03)
    assert row["percent"] == pytest.approx(-100 * means[0] / BASE[chosen].mean())


def test_chance_is_not_called_significant() -> None:
    seed, draws = 41, 100
    print("seed", seed)
    rng = np.random.default_rng(seed)
    alarms = [
        (significance_table(TABLE, BASE, r, NOISE, COVARIANCE, EDGES)["p_corrected"] < 0.05).any()
        for r in COVARIANCE.sample(rng, draws).T
    ]
    print(np.mean(alarms))
    assert np.mean(alarms) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / draws)


def test_force_that_is_high_on_loading_above_a_pressure() -> None:
    off = (
        (~synthetic.is_angle(TABLE))
        & (TABLE["pressure_kPa"] > 175)
        & (TABLE["branch"] == "loading")
    )
    residual = np.where(off, -0.12 * BASE / 1.12, 0.0)
    found = sentences(table_of(residual))
    assert found[0].startswith("the simulated tip angle is right (within ")
    assert found[1].startswith("up to 175 kPa the simulated force is right (within ")
    assert found[2].startswith(
        "above 175 kPa the simulated force is 12 % high on loading and right (within "
    )
    assert found[2].endswith("on unloading")
    assert len(found) == 3


def test_what_is_low_everywhere_is_one_sentence() -> None:
    found = sentences(table_of(np.where(synthetic.is_angle(TABLE), 0.25 * BASE, 0.0)))
    assert (
        found[0] == ("the simulated tip angle is 20 % low on loading and 20 % low on unloading")
        or found[0] == "the simulated tip angle is 20 % low"
    )


def test_cycles_and_specimens_that_differ_are_told() -> None:
    index = synthetic.index(specimens=2, cycles=2)
    base = synthetic.base(index)
    off = (~synthetic.is_angle(index)) & (index["cycle"] == 1)
    found = sentences(table_of(np.where(off, 0.1 * base, 0.0), index))
    assert any(
        text.startswith("the simulated force is 9.1 % low in cycle 1 and right (within")
        for text in found
    )
    assert not any("on specimen" in text for text in found)


def test_sizes_near_zero_are_told_in_the_channels_unit() -> None:
    index = TABLE.assign(channel="tip_z_mm", experiment="bending")
    noise = np.eye(len(index)) * 0.01
    residual = np.full(len(index), -0.5)
    measured = np.full(len(index), 1e-3)
    table = significance_table(index, measured, residual, noise, Covariance.of(noise), [0.0, 250.0])
    assert sentences(table)[0].startswith("the simulated tip's displacement along z is 0.5 mm high")

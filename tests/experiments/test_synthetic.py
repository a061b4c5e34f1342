"""Synthetic measurements: noise and nuisances as asked for, hidden values kept out."""

from __future__ import annotations

import csv
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from support.command import run_command

from dolfingrip import config
from dolfingrip.config import ConfigError, changed
from dolfingrip.experiments import synthetic
from dolfingrip.experiments.synthetic import SyntheticMeasurement
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.index import NAMES
from dolfingrip.sections.tables import assignments

COUPON = ("coupon.max_strain=0.4", "coupon.step_strain=0.002")
SELF = MPI.COMM_SELF


def pulled(seed: int = 3, **more: object) -> SyntheticMeasurement:
    """A coupon's measurement: 201 readings in a second."""
    told = config.load(None, assignments(COUPON))
    truth = changed(told, assignments(["material.mu_MPa=2.0"]))
    return synthetic.measure(["coupon"], told, hidden=truth, seed=seed, comm=SELF, **more)


def column(measurement: SyntheticMeasurement, name: str) -> np.ndarray:
    return np.array([row[name] for row in measurement.rows])


def test_noise_has_the_spread_that_is_asked_for() -> None:
    """Of 201 readings to 20 %, four standard errors of a standard deviation."""
    noise = {**synthetic.NOISE, "force_N": 0.1, "displacement_mm": 0.0}
    silent = dict.fromkeys(noise, 0.0)
    noisy, clean = (pulled(noise=spread) for spread in (noise, silent))
    error = column(noisy, "force_N") - column(clean, "force_N")
    assert np.std(error) == pytest.approx(0.1, rel=0.2)
    assert abs(error.mean()) < 4 * 0.1 / math.sqrt(201)
    np.testing.assert_array_equal(
        column(noisy, "displacement_mm"), column(clean, "displacement_mm")
    )
    width = column(noisy, "transverse_strain") - column(clean, "transverse_strain")
    assert np.std(width) == pytest.approx(0.002, rel=0.2)
    assert dict(noisy.noise) == {
        "force_N": 0.1, "displacement_mm": 0.0, "transverse_strain": 0.002
    }  # fmt: skip


def test_the_seed_decides() -> None:
    first, again, other = (pulled(seed, nuisances=["force_gain"]) for seed in (3, 3, 4))
    assert first.rows == again.rows
    assert first.truth == again.truth
    assert first.truth.extensions.force_gain != other.truth.extensions.force_gain
    assert np.abs(column(first, "force_N") - column(other, "force_N")).max() > 0


def test_what_is_written_is_a_measurement_and_hides_the_truth(tmp_path: Path) -> None:
    found = pulled(nuisances=["force_gain"])
    synthetic.write(found, tmp_path, SELF)
    with (tmp_path / "measured.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 201
    assert list(rows[0]) == [
        "experiment", "specimen", "cycle", "branch", "time_s", "force_N", "displacement_mm",
        "transverse_strain",
    ]  # fmt: skip
    assert {row["experiment"] for row in rows} == {"coupon"}
    text = (tmp_path / "measured.toml").read_text(encoding="utf-8")
    told = tomllib.loads(text)
    assert told["experiment"] == "coupon"
    assert told["area_mm2"] == 9.0
    assert told["noise"]["force_N"] == synthetic.NOISE["force_N"]
    assert not any(word in text for word in ("mu_MPa", "gain", "extensions"))
    truth = config.load(tmp_path / "truth.toml")
    assert truth.material.mu_MPa == 2.0
    assert truth.extensions.force_gain == found.truth.extensions.force_gain


@pytest.mark.parametrize("prior", [Prior(0.5, 2.0, "-"), Prior(0.5, 0.6, "-", positive=True)])
def test_draws_have_the_priors_mean_and_spread(prior: Prior) -> None:
    """To some standard errors of 20,000 draws."""
    rng = np.random.default_rng(8)
    draws = np.array([prior.at(float(normal)) for normal in rng.standard_normal(20_000)])
    assert draws.mean() == pytest.approx(prior.mean, abs=5 * prior.spread / math.sqrt(20_000))
    assert draws.std() == pytest.approx(prior.spread, rel=0.08)
    assert prior.positive == bool((draws > 0).all())


def test_any_effect_can_be_drawn() -> None:
    rng = np.random.default_rng(1)
    for name in NAMES:
        found = synthetic.drawn(config.Config(), [name], rng)
        assert len(found.extensions.active()) == 1


def test_the_command(tmp_path: Path) -> None:
    asked = ["--experiments", "coupon", "--out", str(tmp_path / "synthetic")]
    hidden = ("--hide", "extensions.force_gain.gain=1.1")
    assert run_command("synthetic", *asked, *hidden, "--set", "coupon.max_strain=0.1") == 0
    assert config.load(tmp_path / "synthetic" / "truth.toml").extensions.force_gain.gain == 1.1
    assert run_command("synthetic", "--experiments", "coupon,tension") == 2
    assert run_command("synthetic", *asked, "--noise", "angle=1") == 2


def test_bad_input_is_said_in_one_line() -> None:
    with pytest.raises(ConfigError, match=r"--noise force = 1: allowed: pressure_kPa, volume_ml, "):
        synthetic.check_noise({"force": 1})
    with pytest.raises(ConfigError, match=r"--noise force_N = -1: allowed: a number from 0 on"):
        synthetic.check_noise({"force_N": -1})
    with pytest.raises(ConfigError, match=r"--nuisance gravity: no effect; allowed: bulk_modulus"):
        synthetic.drawn(config.Config(), ["gravity"], np.random.default_rng(1))

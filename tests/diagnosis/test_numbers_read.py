"""Numbers that a laboratory reads by themselves: they stand beside the readings of its tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.here import Here
from support.invented_coupon import made, white

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.diagnosis.additions.checks import numbers_read
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement

GAIN = "extensions.force_gain.gain"
TOLD = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.02
displacement_mm = 0.0
[nuisance]
material_law = 0.0
coupon_slack_mm = 0.0
"""


def measured(folder: Path, told: str) -> Path:
    """A coupon whose load cell shows a twentieth too much, as a material that is stiffer does."""

    def noise(rng: np.random.Generator, count: int) -> np.ndarray:
        return white(rng, count, 0.02)

    return made(folder, f"{GAIN}=1.05", noise=noise, told=TOLD + told)


def diagnosed(folder: Path, store: Path, told: str) -> Diagnosis:
    settings = DiagnosisSettings(effects=("force_gain", "bulk_modulus"), quick=True)
    measurement = read([measured(folder, told)], Config())
    return diagnose_measurement(measurement, Config(), Here(store), settings)


def test_a_gain_that_is_read_is_named_and_the_modulus_stays(tmp_path: Path, store: Path) -> None:
    """Readings alone give the modulus all; a weight on the load cell tells the gain."""
    alone = diagnosed(tmp_path / "alone", store, "")
    assert alone.decision.answer == "none"
    (weight,) = (check for check in alone.next if "force_gain" in check.tells)
    (gain,) = (quantity for quantity in weight.quantities if quantity.key == GAIN)
    assert (gain.configured, gain.std, gain.unit) == (1.0, 0.002, "")
    told = f"{GAIN} = {{value = 1.051, std = {gain.std}}}\n"
    found = diagnosed(tmp_path / "told", store, told)
    assert (found.decision.answer, found.decision.first) == ("cause", ("force_gain",))
    assert found.claimed
    by_key = {number.key: number for number in found.numbers(found.decision.best)}
    assert by_key[GAIN].value == pytest.approx(1.051, abs=0.001)
    # reference: the material is as configured, and was 5 % off where the gain was not told
    assert by_key["material.mu_MPa"].value == pytest.approx(2.93, rel=0.01)
    before = alone.numbers(alone.none)[0]
    assert before.value == pytest.approx(1.05 * 2.93, rel=0.01)
    assert not any("force_gain" in check.tells for check in found.next)


def test_a_gain_that_is_read_as_configured_is_none(tmp_path: Path, store: Path) -> None:
    found = diagnosed(tmp_path, store, f"{GAIN} = {{value = 1.001, std = 0.002}}\n")
    assert found.decision.answer == "none"
    by_key = {number.key: number for number in found.numbers(found.member("force_gain"))}
    assert 0.995 < by_key[GAIN].low < 1.0 < by_key[GAIN].high < 1.006
    assert not any("force_gain" in check.tells for check in found.next)


def test_a_gain_that_is_told_within_a_deviation_is_of_the_rig(tmp_path: Path) -> None:
    """Reference: a load cell that shows two hundredths more shows these of every force."""
    measurement = read([measured(tmp_path, f"{GAIN} = 0.02\n")], Config())
    simulation = CouponSimulation(measurement, Config())
    (gain,) = (number for number in simulation.rig if number.name == GAIN)
    assert gain.change == pytest.approx(0.02 * simulation.configured)
    on = CouponSimulation(measurement, changed(Config(), {GAIN: 1.05}))
    (gain,) = on.rig
    assert gain.change == pytest.approx(0.02 / 1.05 * on.configured)


def test_a_number_that_nothing_tells_is_refused(tmp_path: Path) -> None:
    told = "material.nu = {value = 0.4, std = 0.1}\n"
    with pytest.raises(ConfigError, match=r"material.nu.*allowed: .*extensions.force_gain.gain"):
        numbers_read(read([measured(tmp_path, told)], Config()), Config())
    told = f"{GAIN} = {{value = 1.0, std = -0.1}}\n"
    with pytest.raises(ConfigError, match=r"nuisance.extensions.force_gain.gain = -0.1: allowed"):
        read([measured(tmp_path, told)], Config())

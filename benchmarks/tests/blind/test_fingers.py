"""The blind benchmark of fingers: what is hidden, how it is read, and the files; no simulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.pretended_finger import Pretended

from benchmarks.blind import ci
from benchmarks.blind.case import FAR, SEEN
from benchmarks.blind.fingers import cases, finger
from benchmarks.blind.fingers.finger import PROTOCOLS, Truth
from benchmarks.blind.fingers.outsiders import OUTSIDERS
from dolfingrip.diagnosis.answer.noise import instrument_noise
from dolfingrip.diagnosis.data.measurement import read

SEED = 11


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> cases.Bench:
    monkeypatch.setattr(cases, "Workers", Pretended)
    return cases.Bench(PROTOCOLS["short"], tmp_path, 1, ci.EFFECTS)


@pytest.mark.parametrize("name", PROTOCOLS)
def test_files_are_valid_measured_data(name: str, tmp_path: Path) -> None:
    """Rows, noise and set-up are read as they are told, without a warning."""
    protocol = PROTOCOLS[name]
    true = finger.measured(protocol, Truth(modulus=1.3), Pretended(tmp_path))
    print("seed", SEED)
    scattered = finger.scattered(protocol, true, np.random.default_rng(SEED))
    measurement = read([finger.write(protocol, scattered, tmp_path)], protocol.analysed())
    assert not measurement.warnings
    assert [test.experiment for test in measurement.tests] == list(protocol.tests)
    listed = measurement.listed
    assert listed["value"].isna().sum() == 0
    shown = np.sort(finger.flat(protocol, scattered))
    std = np.array([protocol.std(column) for column in listed["column"]])
    np.testing.assert_allclose(
        np.sort(listed["value"] / std), shown[~np.isnan(shown)], rtol=1e-4, atol=1e-4
    )
    assert 0 < np.isnan(shown).mean() < 0.3
    told = instrument_noise(measurement)
    np.testing.assert_allclose(np.hypot(told.independent, told.correlated), std, rtol=1e-3)
    blocked = measurement.tests[1].setup
    assert blocked.sections["plate"] == {"gap_mm": protocol.gap_mm}
    assert blocked.nuisances["pressure_offset_kPa"] == protocol.offset_std_kPa


def test_noise_has_the_size_that_is_told_and_drifts() -> None:
    protocol = PROTOCOLS["short"]
    quiet = [
        rows.assign(**dict.fromkeys(names, 0.0))
        for rows, names in zip(protocol.tests.values(), protocol.columns.values(), strict=True)
    ]
    rng = np.random.default_rng(SEED)
    draws = np.array(
        [finger.flat(protocol, finger.scattered(protocol, quiet, rng)) for _ in range(1500)]
    )
    # standard error of a variance of 1400 draws: 1.4/√1400; five of them
    np.testing.assert_allclose(np.nanvar(draws, axis=0), 1.0, atol=0.19)
    after = np.nanmean(draws[:, 1:21] * draws[:, :20])
    near = finger.SHARE * np.exp(-0.2 / finger.LASTS_S)  # 5 kPa at 25 kPa/s
    assert after == pytest.approx(near, abs=0.03)


def test_the_generator_is_not_the_analyser() -> None:
    """All that is hidden at once, and another mesh, barriers and steps."""
    protocol = PROTOCOLS["reference"]
    causes = {"extensions.yeoh.C20_MPa": 0.1, "extensions.prony.tau_s": [8.0]}
    far = {"wall_offset": -2.0, "plate_gap": 1.0, "pressure_gain": 4.0, "pressure_offset": -1.0}
    config = finger.configured(protocol, Truth(causes, ("deep_clamp", 1.0), 1.5, far))
    told = protocol.analysed()
    assert config.material.mu_MPa == pytest.approx(1.5 * told.material.mu_MPa)
    assert config.extensions.yeoh.C20_MPa == pytest.approx(0.15)
    assert config.extensions.prony.tau_s == (8.0,)
    assert config.finger.wall_mm == pytest.approx(0.9 * told.finger.wall_mm)
    assert config.finger.length_mm == pytest.approx(told.finger.length_mm - 2.0)
    assert config.plate.gap_mm == pytest.approx(1.3)
    assert config.extensions.pressure_gain.gain == pytest.approx(1.06)
    assert config.extensions.pressure_offset.offset_kPa == pytest.approx(-2.0)
    for section in ("contact", "plate", "mesh", "solver"):
        assert getattr(config, section) != getattr(told, section)


def test_outsiders_change_what_they_say() -> None:
    rows = PROTOCOLS["reference"].tests["bending"]
    shown = rows["pressure_kPa"].to_numpy()
    leak, stuck = OUTSIDERS["opening_leak"].pressure, OUTSIDERS["backlash"].pressure
    assert leak is not None
    assert stuck is not None
    lost = shown - leak(rows, 1.0)
    np.testing.assert_allclose(lost[[5, 10]], [15 / 8, 15])
    off = stuck(rows, 1.0) - shown
    np.testing.assert_allclose(off[[0, 1, 10, 11, 19, 20]], [0, 4, 4, -4, -4, 0])
    true = {"angle_deg": shown / 2.5, "force_N": shown / 1000}
    by_name = {
        name: each.displayed(rows, true, 2.0) for name, each in OUTSIDERS.items() if each.displayed
    }
    assert by_name["perspective"]["angle_deg"][10] == pytest.approx(110)
    assert by_name["soft_foam"]["force_N"][10] == pytest.approx(0.25**2 / 0.35)
    np.testing.assert_allclose(by_name["slip"]["force_N"][[5, 10, 15]], [0.125, 0.15, 0.025])


def test_cases_are_those_of_the_seed_and_are_seen(bench: cases.Bench) -> None:
    """Only a force's offset is felt here, and a gain of the pressure."""
    for kind in ("one", "with_outsider"):
        case = cases.drawn(bench, "development", kind, 2)
        assert case == cases.drawn(bench, "development", kind, 2)
        assert case != cases.drawn(bench, "confirmation", kind, 2)
        assert case.names == ("force_offset",)
        assert len(case.zeta) == 1
        assert min(case.sigma) >= SEEN
        assert bool(case.truth.outsider[0]) is (kind == "with_outsider")
    for number, name in enumerate(cases.NUISANCES):
        case = cases.drawn(bench, "development", "nuisance", number)
        assert case.names == (name,)
        off = case.truth.far | {"modulus": np.log(case.truth.modulus) / finger.MODULUS}
        assert FAR[0] <= abs(off.pop(name)) <= FAR[1]
        assert all(abs(each) <= cases.WIDEST for each in off.values())
    none = cases.drawn(bench, "development", "none", 0)
    assert (none.names, none.truth.causes, none.truth.outsider[0]) == ((), {}, "")


@pytest.mark.parametrize("outsider", [("", 0.0), ("backlash", 1.0)])
def test_a_finger_without_memory_is_simulated_once(outsider: tuple[str, float]) -> None:
    """Each row is read at the stop of its pressure: of what is there, not of what is displayed."""
    truth = Truth(outsider=outsider)
    rich = PROTOCOLS["rich"]
    act = OUTSIDERS[outsider[0]].pressure if outsider[0] else None
    for (experiment, rows), (asked, stops) in zip(
        rich.tests.items(), finger.simulated(rich, truth), strict=True
    ):
        if experiment == "coupon":
            continue
        pressure = np.array(asked.config.protocol.pressure_kPa)
        there = act(rows, outsider[1]) if act else rows["pressure_kPa"].to_numpy()
        assert (np.diff(pressure) > 0).all()
        assert pressure[stops] == pytest.approx(there)

"""Which stops a measurement asks for."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.measured_files import written

from dolfingrip.config import Config, changed
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.simulation.simulated import groups, path_independent
from dolfingrip.experiments.index import find
from dolfingrip.sections.tables import assignments

SEED = 9
HEADER = "specimen,cycle,branch,time_s,pressure_kPa,angle_deg"


def measured(folder: Path, lines: list[str], more: str = "") -> Measurement:
    text = "\n".join([HEADER, *lines]) + "\n"
    return read([written(folder, text, f'experiment = "bending"\n{more}')])


def cycle(name: str, ups: int, waits: int, sigma: float = 0.0, rate: float = 10.0) -> list[str]:
    """Up to 100 kPa, a wait of 20 s and down, with noise on the gauge."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    way = [("loading", p / rate, p) for p in np.linspace(0, 100, ups)]
    way += [("hold", 100 / rate + 20 * k / waits, 100.0) for k in range(1, waits + 1)]
    way += [("unloading", 20 + (200 - p) / rate, p) for p in np.linspace(100, 0, ups)[1:]]
    return [f"{name},1,{b},{t:.4f},{p + rng.normal(0, sigma):.4f},1.0" for b, t, p in way]


def test_few_rows_are_the_stops(tmp_path: Path) -> None:
    (group,) = groups(measured(tmp_path, cycle("A", 6, 4)), Config())
    np.testing.assert_allclose(group.curve.value, np.linspace(0, 100, 6))
    way = group.in_time
    np.testing.assert_allclose(
        way.value, [0, 20, 40, 60, 80, 100, 100, 100, 100, 100, 80, 60, 40, 20, 0]
    )
    np.testing.assert_allclose(way.time_s[6:10], [15, 20, 25, 30])
    assert way.branch[5:11] == ("loading", *4 * ("hold",), "unloading")
    stops = find("bending").schedule(Config().changed(protocol=way.protocol()))
    assert [stop.branch for stop in stops] == list(way.branch)
    # readings that are the stops' own come back as they are
    values = np.arange(15.0)
    np.testing.assert_allclose(way.at_rows(values, 15), values, atol=1e-12)


def test_many_noisy_rows_make_a_smooth_way(tmp_path: Path) -> None:
    measurement = measured(tmp_path, cycle("A", 200, 60, sigma=0.5))
    (group,) = groups(measurement, Config())
    way = group.in_time
    assert len(group.curve.value) <= Policy().most_stops + 1
    assert len(way.value) <= 2 * (Policy().most_stops + 2) + 2 * Policy().few + 1
    up, wait, down = (
        [v for v, b in zip(way.value, way.branch, strict=True) if b == name]
        for name in ("loading", "hold", "unloading")
    )
    assert (np.diff(up) > 0).all()
    assert (np.diff(down) < 0).all()
    assert len(set(wait)) == 1
    assert (np.diff(way.time_s) >= 0).all()
    # at its stops the way is the ramp's, to a few of 0.5 kPa / sqrt(8)
    ramp = np.array([(t, v) for t, v, b in zip(way.time_s, way.value, way.branch, strict=True)
                     if b == "loading"])  # fmt: skip
    assert np.abs(ramp[1:-1, 1] - 10 * ramp[1:-1, 0]).max() < 0.8
    # what is linear in pressure is so in every row, at the pressure that was read
    rows = group.in_time.at_rows(np.array(way.value), len(measurement.readings))
    told = measurement.readings["pressure_kPa"].to_numpy()
    ramps = (measurement.readings["branch"] != "hold").to_numpy()
    np.testing.assert_allclose(rows[ramps], told[ramps], atol=1e-9)


def test_rows_within_the_gauges_noise_are_averaged(tmp_path: Path) -> None:
    """A ramp of 12 kPa read 25 times by a gauge of 0.5 kPa: five stops and the ends; one wait."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    way = [("loading", 12 * k / 24) for k in range(25)] + [("hold", 12.0)] * 20
    lines = [
        f"A,1,{branch},{i},{p + rng.normal(0, 0.5):.4f},1.0" for i, (branch, p) in enumerate(way)
    ]
    (group,) = groups(measured(tmp_path, lines, "[noise]\npressure_kPa = 0.5\n"), Config())
    assert len(group.in_time.legs) == 2
    assert group.in_time.branch.count("loading") <= 7
    held = {
        v for v, b in zip(group.in_time.value, group.in_time.branch, strict=True) if b == "hold"
    }
    (value,) = held
    assert value == pytest.approx(12.0, abs=3 * 0.5 / math.sqrt(21))
    # the ramp leads there, and the elastic curve is read there, too
    assert group.in_time.value[group.in_time.branch.index("hold") - 1] == value
    assert group.curve.legs[0].rows_at[-1] == value
    assert (np.diff(group.in_time.value) >= 0).all()


@pytest.mark.parametrize(("sigma", "told"), [(0.5, "[noise]\npressure_kPa = 0.5\n"), (0.2, "")])
def test_noise_of_the_gauge_moves_no_stop(tmp_path: Path, sigma: float, told: str) -> None:
    """Led alike, read with other noise, told or not: the same simulations, at one rate."""
    (exact,) = groups(measured(tmp_path, cycle("A", 6, 4)), Config())
    measurement = measured(tmp_path, cycle("A", 6, 4, sigma=sigma), told)
    (noisy,) = groups(measurement, Config())
    assert noisy.in_time.value == exact.in_time.value
    assert noisy.in_time.time_s == exact.in_time.time_s
    assert tuple(noisy.curve.value) == tuple(exact.curve.value)
    # rows are read where they were read
    rows = noisy.in_time.at_rows(np.array(noisy.in_time.value), len(measurement.readings))
    told_kPa = measurement.readings["pressure_kPa"].to_numpy()
    ramps = (measurement.readings["branch"] != "hold").to_numpy()
    np.testing.assert_allclose(rows[ramps], told_kPa[ramps], atol=1e-9)


def test_a_turn_stays_where_noise_does_not_explain_it(tmp_path: Path) -> None:
    lines = [f"A,1,loading,{p / 10:.4f},{p},1" for p in (0.1, 21.0, 43.0, 63.0, 83.7)]
    (group,) = groups(measured(tmp_path, lines, "[noise]\npressure_kPa = 0.1\n"), Config())
    np.testing.assert_allclose(group.in_time.value, [0.0, 21.0, 43.0, 63.0, 83.7])
    np.testing.assert_allclose(group.in_time.time_s, np.array(group.in_time.value) / 10, atol=0.02)


def test_specimens_share_what_they_went_through_alike(tmp_path: Path) -> None:
    lines = cycle("A", 6, 4) + cycle("B", 6, 4) + cycle("C", 6, 4, rate=2.0)
    found = groups(measured(tmp_path, lines), Config())
    assert [group.tests for group in found] == [(0, 1), (2,)]
    # what has no memory is one curve for all three
    assert found[0].curve.value == found[1].curve.value
    own = measured(tmp_path, lines, "[specimen.B]\nwall_mm = 1.7\n")
    assert [group.tests for group in groups(own, Config())] == [(0,), (2,), (1,)]


def test_cycles_of_which_only_the_loading_is_read(tmp_path: Path) -> None:
    """Between two loadings the pressure went back, though nothing was read of that."""
    up = [20.0, 40.0, 60.0, 80.0, 100.0]
    lines = [f"A,{k + 1},loading,{20 * k + p / 10},{p},1" for k in range(3) for p in up]
    (group,) = groups(measured(tmp_path, lines), Config())
    way = group.in_time
    assert way.value == (*up, *up, *up)
    assert way.branch[4:7] == ("loading", "unloading", "loading")
    values = np.arange(15.0)
    np.testing.assert_allclose(way.at_rows(values, 15), values, atol=1e-12)
    stops = find("bending").schedule(Config().changed(protocol=way.protocol()))
    assert len(stops) == 15


def test_a_settled_cycle_is_read_again(tmp_path: Path) -> None:
    """The third of three alike is the second, and a fourth that goes farther is led."""
    up, down = [20.0, 40.0, 60.0], [40.0, 20.0, 0.0]
    one = [("loading", p) for p in up] + [("unloading", p) for p in down]
    way = [(c, *each) for c in (1, 2, 3) for each in one] + [(4, "loading", 90.0)]
    lines = [f"A,{c},{branch},{k},{p},1" for k, (c, branch, p) in enumerate(way)]
    (group,) = groups(measured(tmp_path, lines), Config())
    assert group.settled.value == (*up, *down, *up, *down, 90.0)
    rows = group.settled.at_rows(np.arange(13.0), len(way))
    np.testing.assert_allclose(rows, [*range(12), *range(6, 12), 12], atol=1e-12)
    assert len(group.in_time.value) == len(way)
    # the first to go so far is not like any before
    lines = [f"A,{c},loading,{2 * c + k},{p},1" for c in (1, 2, 3) for k, p in ((0, 5), (1, 9 + c))]
    (own,) = groups(measured(tmp_path, lines), Config())
    assert own.settled.value == own.in_time.value


@pytest.mark.parametrize(
    ("effects", "route"),
    [
        ((), "curve"),
        (("mullins", "permanent_set", "plate_friction", "bellows_friction"), "settled"),
        (("mullins", "set_point_logged"), "in_time"),
        (("prony",), "in_time"),
    ],
)
def test_what_has_no_clock_settles(tmp_path: Path, effects: tuple[str, ...], route: str) -> None:
    (group,) = groups(measured(tmp_path, cycle("A", 6, 4)), Config())
    config = changed(Config(), assignments([f"extensions.{name}={{}}" for name in effects]))
    assert group.schedule(config) is getattr(group, route)


def test_pulses_are_waits_apart(tmp_path: Path) -> None:
    lines = [f"A,{1 + k // 20},hold,{0.5 * k:.2f},{20.0 * (k // 10 % 2):.1f},1" for k in range(40)]
    (group,) = groups(measured(tmp_path, lines), Config())
    way = group.in_time
    assert [way.branch[leg.stops[-1]] for leg in way.legs].count("hold") == 4
    assert set(group.in_time.value) == {0.0, 20.0}


@pytest.mark.parametrize(
    ("override", "independent"),
    [
        ("extensions.mooney_rivlin.C01_MPa=1", True),
        ("extensions.wall_offset.offset_mm=0.1", True),
        ("extensions.prony.tau_s=[1.0]", False),
        ("extensions.plate_friction.mu=0.5", False),
        ("extensions.set_point_logged.tau_s=0.1", False),
    ],
)
def test_memory_and_clock(override: str, independent: bool) -> None:
    assert path_independent(changed(Config(), assignments([override]))) == independent

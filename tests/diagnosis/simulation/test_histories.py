"""The rows of a test decide where it is simulated, whatever they are called and however it went."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.simulation.simulated import groups
from dolfingrip.diagnosis.simulation.stops import StopSchedule
from dolfingrip.experiments.index import find

SEED = 11
TOP_kPa = 100.0

Row = tuple[float, float]


def ramp(to: float, start: Row, rate: float, rows: int) -> list[Row]:
    """Rows (time in s, pressure in kPa) of a ramp, without its start."""
    time_s, value = start
    lasts_s = abs(to - value) / rate
    return [(time_s + lasts_s * k / rows, value + (to - value) * k / rows)
            for k in range(1, rows + 1)]  # fmt: skip


def wait(start: Row, lasts_s: float, rows: int) -> list[Row]:
    return [(start[0] + lasts_s * k / rows, start[1]) for k in range(1, rows + 1)]


def through(places: list[float], rate: float = 10.0, rows: int = 1, waits_s: float = 0.0,
            of_wait: int = 0, first: Row = (0.0, 0.0)) -> list[Row]:  # fmt: skip
    """Rows of ramps to each place, with a wait at each."""
    found = [first]
    for place in places:
        found += ramp(place, found[-1], rate, rows)
        if of_wait:
            found += wait(found[-1], waits_s, of_wait)
        elif waits_s:
            found[-1] = (found[-1][0] + waits_s, place)
    return found


UP = [20.0, 40.0, 60.0, 80.0, TOP_kPa]
PULSES = [p for up in UP for p in (up, 0.0)]
HISTORIES: dict[str, list[Row]] = {
    "ramp": through([TOP_kPa], rows=5),
    "steps, read once at their end": through(UP, waits_s=10.0),
    "steps, read while they wait": through(UP, waits_s=10.0, of_wait=20),
    "steps up and down": through([*UP, *UP[-2::-1], 0.0], waits_s=5.0, of_wait=4),
    "pulses from zero": through(PULSES, waits_s=5.0),
    "pulses from zero, read while they wait": through(PULSES, waits_s=5.0, of_wait=10),
    "three cycles, dense": through(3 * [TOP_kPa, 0.0], rows=200),
    "cycles that begin with a row at rest": [
        (t + 30.0 * k, p) for k in range(3) for t, p in through([TOP_kPa, 0.0], rows=5)
    ],
    "cycles of which only the loading is read": [
        (t + 40.0 * k, p) for k in range(3) for t, p in through([TOP_kPa], rows=5)[1:]
    ],
    "a vent slower than the ramp": [
        *through([TOP_kPa], rows=5), *ramp(0.0, (10.0, TOP_kPa), 1.0, 20)
    ],
    "begins above rest, goes back in part": through([60.0, 40.0, TOP_kPa], rows=4,
                                                    first=(0.0, 30.0)),
    "a hold of an hour, read ever sparser": [
        *through([TOP_kPa], rows=5), *((10.0 + 2.0**k, TOP_kPa) for k in range(13))
    ],
}  # fmt: skip
"""Twelve ways in which laboratories lead a test."""

NAMES = {
    "as told": lambda before, now: "loading" if now > before else "unloading",
    "hold": lambda before, now: "hold",
    "loading": lambda before, now: "loading",
    "none": lambda before, now: "",
}


def measured(folder: Path, rows: list[Row], named: str, sigma: float = 0.0) -> Measurement:
    """Readings of a finger that turns by sin(p/100 kPa) · 40°, whatever its history."""
    print("seed", SEED)
    noise = (
        np.random.default_rng(SEED).normal(0, sigma, len(rows)) if sigma else np.zeros(len(rows))
    )
    before = [rows[0][1], *(p for _, p in rows)]
    lines = [
        f"{NAMES[named](b, p)},{t:.6f},{p + e:.6f},{40 * np.sin(p / 100):.6f}"
        for b, (t, p), e in zip(before, rows, noise, strict=False)
    ]
    text = "branch,time_s,pressure_kPa,angle_deg\n" + "\n".join(dict.fromkeys(lines)) + "\n"
    told = f"[noise]\npressure_kPa = {sigma}\n" if sigma else ""
    folder.mkdir(exist_ok=True)
    return read([written(folder, text, f'experiment = "bending"\n{told}')])


def routes(measurement: Measurement) -> list[StopSchedule]:
    (group,) = groups(measurement, Config())
    return [group.curve, group.in_time, group.settled]


@pytest.mark.parametrize("history", HISTORIES)
def test_the_names_of_branches_decide_nothing(tmp_path: Path, history: str) -> None:
    """The same stops, and the same readings at the rows, for rows of any name."""
    told, *others = (
        routes(measured(tmp_path / str(i), HISTORIES[history], name))
        for i, name in enumerate(NAMES)
    )
    for other in others:
        for one, same in zip(told, other, strict=True):
            assert one.value == same.value
            assert one.time_s == same.time_s
            assert one.branch == same.branch
            assert one.cycle == same.cycle
    bending = find("bending")
    for route in told:  # which the experiment can be led along
        assert bending.schedule(Config().changed(protocol=route.protocol()))
        assert all(b >= a for a, b in pairwise(route.time_s))


@pytest.mark.parametrize("sigma", [0.0, 0.5])
@pytest.mark.parametrize("history", HISTORIES)
def test_every_row_is_read_where_it_was_read(tmp_path: Path, history: str, sigma: float) -> None:
    """An angle of sin(p/100 kPa) · 40° at the stops is so in each row, to a tenth of a degree."""
    measurement = measured(tmp_path, HISTORIES[history], "hold", sigma)
    rows = len(measurement.readings)
    pressure = measurement.readings["pressure_kPa"].to_numpy()
    moves = (measurement.readings["branch"] != "hold").to_numpy()
    for route in routes(measurement):
        at_stops = 40 * np.sin(np.array(route.value) / 100)
        at_rows = route.at_rows(at_stops, rows)
        assert np.isfinite(at_rows).all()
        known = moves if len(route.legs) > 1 else np.full(rows, True)
        error = np.abs(at_rows - 40 * np.sin(pressure / 100))[known]
        # a reading at rest is off by the gauge's noise at most: 0.4° for each kPa
        assert error.max() <= 0.1 + 0.4 * 2 * sigma


@pytest.mark.parametrize(("places", "timed"), [(UP, True), (PULSES, True), (UP, False)])
def test_like_data_share_their_stops(tmp_path: Path, places: list[float], timed: bool) -> None:
    """Sixteen readings of steps or pulses by a gauge of 0.5 kPa; times told or by a rate."""
    print("seeds 0 to 15")
    found = set()
    for seed in range(16):
        noise = np.random.default_rng(seed).normal(0, 0.5, len(places) + 1)
        lines = [f"hold,{10 * i if timed else ''},{p + e:.3f},{p}"
                 for i, (p, e) in enumerate(zip([0.0, *places], noise, strict=True))]  # fmt: skip
        text = "branch,time_s,pressure_kPa,angle_deg\n" + "\n".join(lines) + "\n"
        folder = tmp_path / str(seed)
        folder.mkdir()
        told = "" if timed else "rate_kPa_per_s = 2.0\n"
        toml = f'experiment = "bending"\n{told}[noise]\npressure_kPa = 0.5\n'
        curve, in_time, _ = routes(read([written(folder, text, toml)]))
        found.add((tuple(curve.value), in_time.value, in_time.time_s))
    assert len(found) == 1


def test_noise_of_the_gauge_takes_no_time(tmp_path: Path) -> None:
    """Up to 100 kPa and back at 2 kPa/s, read every 0.5 kPa: 50 s and 100 s, but for the noise."""
    print("seed", SEED)
    way = [p for _, p in through([TOP_kPa, 0.0], rate=2.0, rows=200)]
    read_kPa = np.array(way) + np.random.default_rng(SEED).normal(0, 0.5, len(way))
    text = "pressure_kPa,angle_deg\n" + "".join(f"{p:.3f},1.0\n" for p in read_kPa)
    toml = 'experiment = "bending"\nrate_kPa_per_s = 2.0\n[noise]\npressure_kPa = 0.5\n'
    time_s = read([written(tmp_path, text, toml)]).readings["time_s"].to_numpy()
    assert time_s[[200, 400]] == pytest.approx([50.0, 100.0], abs=1.5)


def test_rows_that_contradict_their_branch_are_doubted(tmp_path: Path) -> None:
    """A travel that falls in rows named loading is said in one sentence."""
    text = "branch,time_s,pressure_kPa,angle_deg\n"
    text += "".join(f"loading,{t},{p},{p}\n" for t, p in ((0, 0), (1, 50), (2, 100), (3, 60)))
    (said,) = read([written(tmp_path, text, 'experiment = "bending"\n')]).warnings
    assert "1 rows are named loading, the first in line 5, but pressure_kPa falls there" in said

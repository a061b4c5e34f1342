"""What a measurement has in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.example import EXAMPLES
from support.measured_files import CSV, TOML, written

from dolfingrip.config import Config, load
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.experiments import synthetic
from dolfingrip.sections.tables import assignments


def test_readings_and_set_ups(tmp_path: Path) -> None:
    found = read([written(tmp_path)])
    assert [(t.experiment, t.specimen) for t in found.tests] == [
        ("bending", "A"), ("blocked_force", "A")
    ]  # fmt: skip
    assert found.warnings == []
    listed = found.listed
    assert list(listed["column"]) == [*4 * ["angle_deg"], "force_N", "angle_deg", "force_N"]
    np.testing.assert_array_equal(listed["value"], [0.1, 12.5, 25.2, 13.0, 0.01, 1.5, 0.3])
    np.testing.assert_array_equal(listed["control"], [0, 25, 50, 25, 0, 25, 25])
    np.testing.assert_array_equal(listed["row"], [0, 1, 2, 3, 4, 5, 5])
    applied = found.tests[1].applied(Config())
    assert (applied.finger.wall_mm, applied.plate.gap_mm) == (1.8, 0.5)
    assert found.tests[0].setup.noise["angle_deg"] == 0.3
    assert found.tests[0].setup.nuisances["modulus"] == 0.2


def test_specimens_differ_and_a_laboratory_knows_better(tmp_path: Path) -> None:
    more = """
[noise.correlated]
angle_deg = 0.2
correlation_time_s = 30
[nuisance]
pressure_gain = 0.005
[gravity]
direction = [0, 0, -1]
[specimen.B]
wall_mm = 1.7
[specimen.B.plate]
gap_mm = 2.0
"""
    csv = CSV + "bending,B,1,loading,0,0,0.0,\nbending,B,1,loading,1,25,14.0,\n"
    found = read([written(tmp_path, csv, TOML + more)])
    first, *_, other = found.tests
    assert first.applied(Config()).finger.wall_mm == 1.8
    applied, last = other.applied(Config()), other.setup
    assert (applied.finger.wall_mm, applied.plate.gap_mm) == (1.7, 2.0)
    assert applied.gravity.acceleration_m_s2 == 9.81
    assert last.nuisances["pressure_gain"] == 0.005
    assert (last.correlated_noise["angle_deg"], last.correlation_time_s) == (0.2, 30.0)


def test_what_one_file_tells_of_the_body_holds_in_the_others(tmp_path: Path) -> None:
    """Walls and chambers are the same in both tests, the regulator's scale is of one file."""
    bent, blocked, *_ = CSV.split("blocked_force", 1)
    own = "[nuisance]\nfinger.gap_mm = 0.1\npressure_gain = 0.005\nplate.tilt_deg = 1.0\n"
    head = CSV.splitlines()[0]
    files = [
        written(tmp_path, bent, TOML.replace(', "blocked_force"', "") + own, "bent"),
        written(tmp_path, f"{head}\nblocked_force{blocked}",
                TOML.replace('"bending", ', ""), "blocked"),
    ]  # fmt: skip
    told, other = (test.setup.nuisances for test in read(files).tests)
    assert told["finger.gap_mm"] == other["finger.gap_mm"] == 0.1
    assert (told["pressure_gain"], other["pressure_gain"]) == (0.005, 0.015)
    assert "plate.tilt_deg" not in other


def test_a_specimen_that_hangs_otherwise_has_the_common_weight(tmp_path: Path) -> None:
    more = "[gravity]\nacceleration_m_s2 = 1.62\n[specimen.A.gravity]\ndirection = [0, 0, 1]\n"
    (first, *_) = read([written(tmp_path, toml=TOML + more)]).tests
    gravity = first.applied(Config()).gravity
    assert (gravity.acceleration_m_s2, tuple(gravity.direction)) == (1.62, (0, 0, 1))


def test_branches_of_cycles_whose_rows_alternate(tmp_path: Path) -> None:
    csv = "cycle,pressure_kPa,angle_deg\n1,0,0\n2,10,1\n1,50,9\n2,20,2\n1,20,4\n2,30,3\n"
    found = read([written(tmp_path, csv, 'experiment = "bending"\nrate_kPa_per_s = 10\n')])
    assert dict(found.readings.groupby("cycle")["branch"].agg(list)) == {
        1: ["loading", "loading", "unloading"], 2: 3 * ["loading"],
    }  # fmt: skip


def test_files_join_and_stay_apart(tmp_path: Path) -> None:
    other = TOML.replace("0.5", "2.0", 1)
    found = read([written(tmp_path), written(tmp_path, toml=other, name="second_gap")])
    assert [test.number for test in found.tests] == [0, 1, 2, 3]
    gaps = [test.applied(Config()).plate.gap_mm for test in found.tests]
    assert gaps == [0.5, 0.5, 2.0, 2.0]
    assert len(found.readings) == 12
    assert list(found.rows(2)["pressure_kPa"]) == [0, 25, 50, 25]


def test_what_is_absent_has_a_meaning(tmp_path: Path) -> None:
    """Time from the rate, branch from the top, specimen from the file."""
    csv = "pressure_kPa,angle_deg,iterations\n0,0,3\n20,9,3\n50,22,4\n20,10,4\n"
    found = read([written(tmp_path, csv, 'experiment = "bending"\nrate_kPa_per_s = 10\n')])
    rows = found.readings
    np.testing.assert_allclose(rows["time_s"], [0, 2, 5, 8])
    assert list(rows["branch"]) == [*3 * ["loading"], "unloading"]
    assert set(rows["specimen"]) == {"lab"}
    assert found.warnings == []
    again = read([written(tmp_path, csv, 'experiment = "bending"\nramp_kPa_per_s = 10\n')])
    assert len(again.warnings) == 2
    assert "ramp_kPa_per_s is not known and not used; did you mean rate_kPa" in again.warnings[0]
    assert "neither time_s nor a rate is told; 25 kPa/s is assumed" in again.warnings[1]


def test_a_chord_between_other_points_is_doubted(tmp_path: Path) -> None:
    csv = "time_s,pressure_kPa,chord_angle_deg\n0,0,0\n1,20,9\n"
    told = 'experiment = "bending"\n[angle]\nfrom = "film edge"\nto = "tip"\n'
    (said,) = read([written(tmp_path, csv, told)]).warnings
    assert "chord_angle_deg is from film edge to tip; simulated is the line from" in said


def test_a_specimen_may_have_a_geometry_and_a_camera_of_its_own() -> None:
    found = read([EXAMPLES / "ecoflex_actuators/bending.csv"])
    assert found.warnings == []
    config = load(None, assignments(["finger.kind=cast"]))
    made = {test.specimen: test.applied(config) for test in found.tests}
    assert {name: each.cast.chambers for name, each in made.items() if each.cast} == {
        "c5-w7": 5,
        "c7-w7": 7,
    }
    assert {each.camera.chord for each in made.values()} == {"back edges"}


def test_a_synthetic_coupon_is_read_as_it_was_written(tmp_path: Path) -> None:
    told = load(None, assignments(["coupon.max_strain=0.1", "coupon.gauge_length_mm=20"]))
    made = synthetic.measure(["coupon"], told, seed=4)
    synthetic.write(made, tmp_path)
    found = read([tmp_path / "measured.csv"])
    assert isinstance(found, Measurement)
    for name in ("force_N", "transverse_strain"):
        listed = found.listed
        own = listed["value"][listed["column"] == name]
        np.testing.assert_allclose(own, [row[name] for row in made.rows], 1e-5)
        assert found.tests[0].setup.noise[name] == synthetic.NOISE[name]
    applied = found.tests[0].applied(Config())
    assert applied.coupon.gauge_length_mm == 20.0
    assert applied.coupon.area_mm2 == pytest.approx(9.0)


def test_the_first_reading_comes_after_the_way_from_rest(tmp_path: Path) -> None:
    """At 10 kPa/s, 30 kPa are there after 3 s; a travel that starts below 0 has no such way."""
    csv = "pressure_kPa,angle_deg\n30,12\n50,25\n0,1\n"
    found = read([written(tmp_path, csv, 'experiment = "bending"\nrate_kPa_per_s = 10\n')])
    np.testing.assert_allclose(found.readings["time_s"], [3, 5, 10])
    csv = "displacement_mm,force_N\n-0.5,0\n1,2\n"
    told = 'experiment = "coupon"\nrate_mm_per_s = 0.5\ngauge_length_mm = 33\narea_mm2 = 9\n'
    found = read([written(tmp_path, csv, told)])
    np.testing.assert_allclose(found.readings["time_s"], [0, 3])


def test_the_rate_of_a_ramp_is_that_without_waits(tmp_path: Path) -> None:
    """5 kPa/s up and, once, 10 kPa/s down; a wait of 100 s is no ramp."""
    rows = [(0, 0, "loading"), (5, 25, "loading"), (10, 50, "loading"), (110, 50, "hold"),
            (112.5, 25, "unloading")]  # fmt: skip
    csv = "time_s,pressure_kPa,branch,angle_deg\n"
    csv += "".join(f"{time},{pressure},{branch},1\n" for time, pressure, branch in rows)
    found = read([written(tmp_path, csv, 'experiment = "bending"\n')])
    assert found.ramp_rate(found.tests[0]) == 5.0
    still = read([written(tmp_path, "time_s,pressure_kPa,angle_deg\n0,20,1\n9,20,2\n",
                          'experiment = "bending"\n')])  # fmt: skip
    assert still.ramp_rate(still.tests[0]) is None

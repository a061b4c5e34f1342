"""Bad data: one line each, which names the file, where in it, the value and what is allowed."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.measured_files import CSV, TOML, written

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import read


def refused(file: Path) -> str:
    """What is said of a file."""
    with pytest.raises(ConfigError) as error:
        read([file])
    said = str(error.value)
    assert said.startswith(str(file.with_suffix("")))
    assert "\n" not in said
    return said


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("angle_deg", "angel_deg", "column angel_deg: unknown; did you mean angle_deg? allowed: "),
        (
            "pressure_kPa",
            "pressure",
            "column pressure: unknown; did you mean pressure_kPa?",
        ),
        (
            "pressure_kPa",
            "pressure_bar",
            "column pressure_bar: unknown; did you mean ",
        ),
        ("time_s", "time", "column time: unknown; did you mean time_s? allowed: "),
        (",force_N", ",pressure_kPa", "column pressure_kPa: twice"),
        ("bending,A,1,loading,1", "bend,A,1,loading,1", "line 3: experiment = bend: unknown; "),
        ("bending,A,1,loading,1", "grasp,A,1,loading,1", "line 3: experiment = grasp: not simul"),
        ("bending,A,1,loading,1", "coupon,A,1,loading,1", "line 3: experiment = coupon: not in "),
        ("A,1,unloading", "A,1,down", "branch = down: allowed: loading, unloading, hold"),
        ("A,1,unloading", "A,1,", "line 5: branch: missing; allowed: loading, unloading, hold"),
        ("A,1,unloading", "A,1.5,unloading", "line 5: cycle = 1.5: allowed: a whole number"),
        ("25.2", "1e-320", "line 4: angle_deg = 1e-320: nearer to 0 than 1e-30; allowed: -720 to"),
        ("25.2", "nan", "line 4: angle_deg = nan: not a finite number; allowed: -720 to 720 deg"),
        ("25.2", "25°", "line 4: angle_deg = 25°: not a number; allowed: -720 to 720 deg"),
        ("25.2", "2520", "line 4: angle_deg = 2520: allowed: -720 to 720 deg"),
        ("2,50,", "2,-150,", "line 4: pressure_kPa = -150: allowed: -101.3 (absolute vacuum) to "),
        ("2,50,", "2,,", "line 4: pressure_kPa: missing; allowed: a number in each row of bending"),
        ("2,50,", ",50,", "line 4: time_s: missing; allowed: a number in each row of bending"),
        ("2,50,", "0.5,50,", "line 4: time_s = 0.5: before the row above of bending of A"),
        ("25.2,", "25.2", "line 4: 7 entries; allowed: as many as the header, 8"),
        ("25.2,", "25.2,0.3", "line 4: force_N = 0.3: bending does not read it; are columns swap"),
        ("1,25,1.5,0.30", "1,25,,", "blocked_force of A: 1 reading; allowed: at least 2"),
        (
            "bending,A,1,loading,2,50,25.2,\n",
            "bending,A,1,loading,1,25,12.5,\n",
            "line 4: the same as line 3 (bending of A); allowed: each row once",
        ),
        (CSV[CSV.index("\n") :], "\n", "no rows; allowed: at least 2 readings"),
        (CSV, "", "empty; allowed: a header line and rows"),
        (CSV, "experiment,time_s,pressure_kPa\nbending,0,0\n", "no reading; allowed: at least one"),
    ],
)
def test_of_the_csv(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = CSV.replace(old, new, 1)
    assert text != CSV
    file = written(tmp_path, text.replace("1,25,,,", "1,25,,"))
    assert said in refused(file)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[finger]", "[finger", "not TOML: "),
        ('"bending", ', '"bendin", ', "experiment = bendin: unknown; did you mean bending? "),
        ('["bending", "blocked_force"]', "3", "experiment = 3: allowed: a name or a list of names"),
        ("wall_mm", "wal_mm", "finger.wal_mm: unknown key; did you mean finger.wall_mm?"),
        (
            "wall_mm = 1.8",
            "wall_mm = -1",
            "finger.wall_mm = -1: allowed: at least 0.001 and at most",
        ),
        ("angle_deg", "angle", "noise.angle: unknown key; did you mean angle_deg? allowed: "),
        ("0.02", "-0.02", "noise.force_N = -0.02: allowed: at least 0"),
        ("0.02", "1e-300", "noise.force_N = 1e-300: allowed: at least 0 and at most 100000 N"),
        ("0.02", "1e18", "noise.force_N = 1e+18: allowed: at least 0 and at most 100000 N"),
        ("[noise]", "[nuisance]\nwalls = 1\n[noise]", "nuisance.walls: unknown key; did you mean "),
        ("[noise]", "[specimen.B]\n[noise]", "[specimen.B]: not in the CSV; allowed: A"),
        ("[noise]", "[specimen.A]\nwal_mm=1\n[noise]", "specimen.A.wal_mm: unknown key; did you"),
        ("[plate]\ngap_mm = 0.5", "plate = 0.5", "plate = 0.5: allowed: a table, [plate]"),
    ],
)
def test_of_the_toml(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = TOML.replace(old, new, 1)
    assert text != TOML
    # a key stays at the top of the file, above its tables
    if new.startswith("plate"):
        text = f"{new}\n{TOML.replace(old, '')}"
    assert said in refused(written(tmp_path, toml=text))


def test_of_a_toml_that_is_not_there(tmp_path: Path) -> None:
    said = refused(written(tmp_path, toml=None))
    assert said.endswith("missing; allowed: a TOML file of the same stem next to lab.csv, with the "
                         "set-up")  # fmt: skip


def test_of_a_csv_that_is_not_there(tmp_path: Path) -> None:
    """It is what was asked for, and not the TOML, which is not there either."""
    assert refused(tmp_path / "nothere.csv").endswith("nothere.csv: no such file")


@pytest.mark.parametrize("key", ["gauge_length_mm", "area_mm2"])
def test_a_coupon_needs_its_dimensions(tmp_path: Path, key: str) -> None:
    csv = "experiment,time_s,displacement_mm,force_N\ncoupon,0,0,0\ncoupon,1,1,2\n"
    toml = "gauge_length_mm = 33.0\narea_mm2 = 9.0\n"
    rest = "".join(line for line in toml.splitlines(keepends=True) if key not in line)
    assert f"{key}: missing; a coupon needs it" in refused(written(tmp_path, csv, rest))


def test_a_file_given_twice(tmp_path: Path) -> None:
    file = written(tmp_path)
    with pytest.raises(ConfigError, match="given twice; allowed: each file once"):
        read([file, file])


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1,16.5,30,-18.4", "transverse_strain = -18.4: allowed: -1 to 1 (no percent)"),
        ("1,16.5,30,-18 %", "transverse_strain = -18 %: not a number; allowed: -1 to 1 (no perce"),
    ],
)
def test_a_width_is_a_strain(tmp_path: Path, row: str, said: str) -> None:
    csv = f"time_s,displacement_mm,force_N,transverse_strain\n0,0,0,0\n{row}\n"
    told = 'experiment = "coupon"\ngauge_length_mm = 33.0\narea_mm2 = 9.0\n'
    assert said in refused(written(tmp_path, csv, told))


def test_a_supply_of_a_cavity_that_the_finger_has_not(tmp_path: Path) -> None:
    file = tmp_path / "arm.csv"
    rows = ["pressure_kPa,cavity_2_supply_kPa,time_s,angle_deg", "0,0,0,0", "0,10,1,2"]
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")
    file.with_suffix(".toml").write_text('experiment = "bending"\n', encoding="utf-8")
    with pytest.raises(
        ConfigError, match=r"column cavity_2_.* no such cavity; allowed: cavity_1_s"
    ):
        read([file], Config())
    read([file])

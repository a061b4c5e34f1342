"""Whole runs on a coarse mesh: what they leave behind, and when they end early."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista
from mpi4py import MPI
from support import small

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.experiments import Result, run
from dolfingrip.experiments.index import find
from dolfingrip.experiments.recorder import columns
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.path.failure import FailureKind
from dolfingrip.mechanics.readings.tip import TipDisplacement
from dolfingrip.report.fields import list_steps

MEASURED = {
    "experiment", "specimen", "cycle", "branch", "time_s", "pressure_kPa", "angle_deg",
    "force_N", "tip_x_mm", "tip_z_mm",
}  # fmt: skip
"""Columns that measurements have too."""

UNLOADED = small.short("experiment.step_kPa=20", "experiment.unload=true")


def _table(folder: Path) -> list[dict[str, str]]:
    with (folder / "result.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _record(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "run.json").read_text(encoding="utf-8")))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bend") / "made" / "here"


@pytest.fixture(scope="module")
def bending(folder: Path) -> Result:
    return run("bending", UNLOADED, out=folder, comm=MPI.COMM_SELF)


def test_rows_go_up_and_back_in_the_measured_format(bending: Result, folder: Path) -> None:
    rows = _table(folder)
    assert set(rows[0]) >= MEASURED
    assert list(rows[0]) == list(columns(find("bending")))
    # 50 is no multiple of 20 and is landed on all the same
    assert [float(row["pressure_kPa"]) for row in rows] == [0, 20, 40, 50, 40, 20, 0]
    assert [row["branch"] for row in rows] == ["loading"] * 4 + ["unloading"] * 3
    rate = UNLOADED.experiment.rate_kPa_per_s
    travelled = np.array([0, 20, 40, 50, 60, 80, 100])
    assert [float(row["time_s"]) for row in rows] == pytest.approx(travelled / rate)
    assert {row["experiment"] for row in rows} == {"bending"}
    assert {row["force_N"] for row in rows} == {""}
    for row, given in zip(rows, bending.rows, strict=True):
        assert float(row["angle_deg"]) == pytest.approx(given["angle_deg"], rel=1e-9, abs=1e-9)


def test_an_elastic_finger_comes_back_the_way_it_went(bending: Result) -> None:
    angle = bending.column("angle_deg")
    assert angle[3] > angle[2] > angle[1] > 1.0
    np.testing.assert_allclose(angle[4:], angle[2::-1], atol=1e-7 * angle[3])
    np.testing.assert_allclose(bending.column("tip_x_mm")[-1], 0.0, atol=1e-7)


def test_a_column_that_is_not_there_is_named_with_those_that_are(bending: Result) -> None:
    with pytest.raises(ConfigError, match=r"^column angle: .* bending; allowed: .*angle_deg"):
        bending.column("angle")
    rows = [{"force_N": 1.0, "branch": "loading"}, {"branch": "loading"}]
    np.testing.assert_array_equal(Result("coupon", UNLOADED, rows).column("force_N"), [1.0, np.nan])


def test_record_tells_all_and_repeats_the_run(bending: Result, folder: Path) -> None:
    record = _record(folder)
    assert record["complete"] is True
    assert record["failure"] is None
    assert (record["experiment"], record["ranks"]) == ("bending", 1)
    assert 50 < record["peak_memory_MB"] < 10_000
    assert record["mesh"]["elements"] > 100
    assert record["mesh"]["dofs"] > record["mesh"]["elements"]
    assert record["newton"]["iterations"] == bending.column("iterations").sum() > 0
    assert record["newton"]["load_steps"] == bending.column("load_steps").sum()
    phases = record["profile"]
    assert {"mesh", "forms", "tangent", "linear solve", "output"} <= phases.keys()
    spent = sum(phase["wall_s"] for phase in phases.values())
    assert 0.5 * record["wall_s"] < spent <= record["wall_s"] + 0.01
    assert {"dolfinx", "gmsh", "petsc4py", "python"} <= record["versions"].keys()
    assert config.load(folder / "run.json") == UNLOADED
    again = run("bending", config.load(folder / "run.json"), comm=MPI.COMM_SELF)
    # to rounding: it depends on where in memory BLAS finds its arrays
    found, expected = (result.column("angle_deg") for result in (again, bending))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_fields_are_one_step_a_row_and_hold_the_tip(bending: Result, folder: Path) -> None:
    reader = pyvista.get_reader(folder / "fields.pvd")
    assert reader.time_values == pytest.approx(bending.column("time_s"))
    assert len(list_steps(folder / "fields.pvd")) == len(bending.rows)
    for step, row in enumerate(bending.rows):
        reader.set_active_time_point(step)
        grid = reader.read()[0]
        moved = grid.point_data["displacement_mm"]
        stretch = grid.point_data["principal_stretch"]
        # the mean over the face, which is nearly rigid, against the mean over its nodes
        tip = grid.points[:, 2] > UNLOADED.finger.length_mm - 1e-6
        assert moved[tip, 0].mean() == pytest.approx(row["tip_x_mm"], abs=0.05)
        # hexahedra integrate with fewer points than nodes: at corners the strain wavers a little
        assert stretch.min() > 0.99
    assert stretch.max() == pytest.approx(1.0, abs=1e-6)


def test_what_is_there_is_readable_while_the_run_goes_on(tmp_path: Path) -> None:
    """As a killed run leaves it: nothing is closed or finished when the files are read."""
    seen = []

    def look(row: dict[str, Any]) -> None:
        seen.append(row["pressure_kPa"])
        rows = _table(tmp_path)
        assert [float(r["pressure_kPa"]) for r in rows] == seen
        reader = pyvista.get_reader(tmp_path / "fields.pvd")
        assert len(reader.time_values) == len(seen)
        assert reader.read()[0].n_cells > 100
        record = _record(tmp_path)
        assert record["complete"] is False
        assert record["failure"] is None
        assert config.load(tmp_path / "run.json") == settings
        if len(seen) == 2:
            raise KeyboardInterrupt

    settings = small.short("experiment.step_kPa=20")
    with pytest.raises(KeyboardInterrupt, match="2 readings, up to 20 kPa, are kept in"):
        run("bending", settings, out=tmp_path, progress=look, comm=MPI.COMM_SELF)
    assert seen == [0.0, 20.0]
    assert len(_table(tmp_path)) == 2
    failure = _record(tmp_path)["failure"]
    assert failure["kind"] == "interrupted"
    assert failure["last_good"] == {"pressure_kPa": 20.0, "time_s": 0.8}


def test_an_error_is_recorded(tmp_path: Path) -> None:
    def fail(row: dict[str, Any]) -> None:
        raise RuntimeError("no more disk")

    settings = small.short("experiment.step_kPa=20")
    with pytest.raises(RuntimeError, match="no more disk"):
        run("bending", settings, out=tmp_path, progress=fail, comm=MPI.COMM_SELF)
    record = _record(tmp_path)
    assert record["complete"] is False
    assert record["failure"]["kind"] == "error"
    assert record["failure"]["sentence"] == "RuntimeError: no more disk"


def test_a_path_that_ends_early_keeps_its_rows_and_says_why(tmp_path: Path) -> None:
    """One iteration, three damped, do for 2 kPa but not for 80; no smaller step is allowed."""
    settings = small.short(
        "solver.max_iterations=1",
        "solver.max_step_kPa=60",
        "solver.min_step_kPa=60",
        "experiment.step_kPa=2",
        "experiment.max_pressure_kPa=2",
    )
    assert run("bending", settings, comm=MPI.COMM_SELF).failure is None

    settings = config.from_dict(
        settings.model_dump(mode="json", exclude_none=True)
        | {"experiment": {"max_pressure_kPa": 80.0, "step_kPa": 80.0}}
    )
    result = run("bending", settings, out=tmp_path, comm=MPI.COMM_SELF)
    failure = result.failure
    assert failure is not None
    assert failure.kind in (FailureKind.ITERATION_LIMIT, FailureKind.LIMIT_POINT)
    assert failure.last_good == {"pressure_kPa": 0.0, "time_s": 0.0}
    assert failure.sentence().startswith(f"stopped at 0 kPa ({failure.kind}): ")
    assert [float(row["pressure_kPa"]) for row in _table(tmp_path)] == [0.0]
    record = _record(tmp_path)
    assert record["complete"] is False
    assert record["failure"]["sentence"] == failure.sentence()
    assert record["failure"]["last_good"] == failure.last_good


WEIGHT = ("gravity.acceleration_m_s2=9.81", "gravity.direction=[-1, 0, 0]")


def test_gravity_sags_the_finger_but_readings_count_from_there() -> None:
    settings = small.short(*WEIGHT, "experiment.step_kPa=50")
    sagged = run("bending", settings, comm=MPI.COMM_SELF)
    rig = find("bending").prepare(settings, MPI.COMM_SELF, Profile())
    path, stops, sags = rig.path(()), find("bending").schedule(settings), []
    assert rig.start(path, stops[0]) is None
    for stop in stops:
        assert path.advance(rig.controls(stop)).failure is None
        sags.append(TipDisplacement(rig.specimen.model, "x").value())
    plain = run("bending", small.short("experiment.step_kPa=50"), comm=MPI.COMM_SELF)
    assert sags[0] < -0.01
    for name in ("angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm"):
        assert sagged.rows[0][name] == 0.0
    assert sagged.rows[1]["tip_x_mm"] == pytest.approx(sags[1] - sags[0], rel=1e-12)
    assert sagged.rows[1]["angle_deg"] == pytest.approx(plain.rows[1]["angle_deg"], rel=0.05)


@pytest.mark.parametrize("control", ["pressure", "volume"])
def test_the_plates_gap_is_from_the_hanging_finger(control: str) -> None:
    """Whichever way it hangs, and however soft the sensor is."""
    settings = small.short(
        *WEIGHT, "plate.gap_mm=0.3", f"experiment.control={control}", "experiment.step_kPa=50",
        "experiment.max_volume_ratio=1.1", "extensions.plate_compliance={}",
        "extensions.plate_friction={}",
    )  # fmt: skip
    result = run("blocked_force", settings, comm=MPI.COMM_SELF)
    first = result.rows[0]
    assert result.failure is None
    assert first["plate_gap_mm"] == pytest.approx(0.3 + settings.plate.barrier_mm, abs=1e-9)
    assert first["force_N"] == 0
    assert first["tip_x_mm"] == first["angle_deg"] == 0
    assert first["pressure_kPa"] == pytest.approx(0, abs=1e-9)
    assert result.rows[-1]["force_N"] > 0.05
    assert result.plate is not None
    normal = np.array(result.plate.normal)
    assert np.array(result.plate.point_mm) @ normal < -0.3 - 0.01  # the skin is at 0 as drawn


def test_a_step_of_the_volume_that_fails_ends_with_a_sentence() -> None:
    settings = small.short(
        "experiment.control=volume", "experiment.max_volume_ratio=3",
        "experiment.step_volume_ratio=2", "solver.max_iterations=1", "solver.max_step_kPa=60",
        "solver.min_step_kPa=60",
    )  # fmt: skip
    result = run("bending", settings, comm=MPI.COMM_SELF)
    assert result.failure is not None
    assert result.failure.kind is not FailureKind.LIMIT_POINT
    assert "mm3" in result.failure.sentence()
    assert len(result.rows) == 1

"""The tip's motion in space: three equal chambers, whole turns, what is told of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from support import small
from support.hexagon import CHAMBERS, hexagon

from dolfingrip import config as configuration
from dolfingrip.experiments import recorder, run
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results import doubts
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.mechanics.readings.rotation import Slices, TipRotation
from dolfingrip.meshes import files


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The hexagonal finger's mesh."""
    path = tmp_path_factory.mktemp("mesh") / "hexagon.msh"
    files.write(path, hexagon())
    return path


def settings(file: Path, cavities: dict[str, dict[str, object]]) -> configuration.Config:
    """The hexagonal finger with these tables of cavities."""
    return configuration.from_dict(
        {
            "finger": {"kind": "adopted"},
            "mesh": {"file": str(file)},
            "material": {"mu_MPa": 0.1},
            "cavity": cavities,
            "contact": {"self_contact": False},
            "solver": {"rtol": 1e-11},
            "experiment": {"max_pressure_kPa": 40.0, "step_kPa": 20.0},
        }
    )


@pytest.fixture(scope="module")
def bent(file: Path) -> dict[str, Result]:
    """Each chamber alone, and all together."""
    found = {}
    for alone in (*CHAMBERS, "all"):
        ratios = {name: {"pressure_ratio": float(alone in (name, "all"))} for name in CHAMBERS}
        found[alone] = run("bending", settings(file, ratios), comm=MPI.COMM_SELF)
        assert found[alone].failure is None
    return found


def test_equal_chambers_bend_alike_in_their_directions(bent: dict[str, Result]) -> None:
    """By symmetry: angles to 1e-6, directions 120° apart to 1e-4°; all together do not bend."""
    angles = [float(bent[name]["bending_angle_deg"][-1]) for name in CHAMBERS]
    ways = np.array([bent[name]["bending_direction_deg"][-1] for name in CHAMBERS])
    print(angles, ways, bent["all"]["bending_angle_deg"])
    assert angles[0] > 0.1
    np.testing.assert_allclose(angles, angles[0], rtol=1e-6)
    apart = np.abs(np.diff(np.unwrap([*ways, ways[0]], period=360.0)))
    np.testing.assert_allclose(apart, 120.0, atol=1e-4)
    assert bent["all"]["bending_angle_deg"][-1] <= 1e-6 * angles[0]
    # a chamber pushes the tip away from its own side: the first one stands at 60°, in x and y
    moved = [bent["cavity"][f"tip_{axis}_mm"][-1] for axis in "xy"]
    assert np.degrees(np.arctan2(moved[1], moved[0])) == pytest.approx(-120.0, abs=1e-3)
    rotation = np.array([bent["cavity"][f"tip_rotation_{axis}_deg"][-1] for axis in "xyz"])
    assert np.linalg.norm(rotation) == pytest.approx(bent["cavity"]["tip_rotation_deg"][-1])


def test_a_motion_out_of_the_plane_is_told(bent: dict[str, Result]) -> None:
    """Where angle_deg is less than the bending; not where it bends in the plane."""
    (told,) = doubts.of_motion(bent["cavity"])
    assert told.title == "plane of bending"
    assert "in the direction of" in told.sentence
    in_plane = [name for name in CHAMBERS if not list(doubts.of_motion(bent[name]))]
    assert len(in_plane) == 1
    size = bent[in_plane[0]]["bending_angle_deg"]
    np.testing.assert_allclose(np.abs(bent[in_plane[0]]["angle_deg"]), size, atol=1e-6)


def test_each_of_several_cavities_has_its_pressure_and_volume(bent: dict[str, Result]) -> None:
    """They add up to the whole, and an unpressurised chamber next to a swollen one shrinks."""
    one = bent["cavity_2"]
    assert one["cavity_2_pressure_kPa"][-1] == pytest.approx(40.0)
    assert one["cavity_1_pressure_kPa"][-1] == one["cavity_3_pressure_kPa"][-1] == 0
    each = [one[f"cavity_{i}_volume_mm3"] for i in (1, 2, 3)]
    np.testing.assert_allclose(sum(each), one["cavity_volume_mm3"], rtol=1e-12)
    np.testing.assert_allclose(each[0], each[2], rtol=1e-6)
    assert each[1][-1] > 1.001 * each[1][0]
    assert set(recorder.columns(EXPERIMENTS["bending"], CHAMBERS)) >= {*one.columns()}
    assert "cavity_1_volume_mm3" not in recorder.columns(EXPERIMENTS["bending"], ("cavity",))


def test_chambers_with_supplies_of_their_own(file: Path, bent: dict[str, Result]) -> None:
    """One after the other: at each stop the finger is as where that chamber alone is driven."""
    drive = {"cavity": {}, "cavity_2": {"pressure_kPa": [0.0, 0.0, 40.0]},
             "cavity_3": {"pressure_kPa": [0.0, 0.0, 0.0]}}  # fmt: skip
    config = settings(file, {}).changed(
        protocol={"time_s": [0.0, 1.0, 2.0], "pressure_kPa": [0.0, 40.0, 0.0]}, cavity=drive
    )
    result = run("bending", config, comm=MPI.COMM_SELF)
    assert result.failure is None
    assert set(result.columns()) <= set(recorder.columns(EXPERIMENTS["bending"], CHAMBERS, config))
    np.testing.assert_allclose(result["cavity_2_supply_kPa"], [0, 0, 40])
    for i, alone in ((1, "cavity"), (2, "cavity_2")):
        for name in ("tip_x_mm", "tip_y_mm", "cavity_1_volume_mm3", "cavity_2_pressure_kPa"):
            assert result[name][i] == pytest.approx(bent[alone][name][-1], rel=1e-6, abs=1e-9)


def test_trapped_air_beside_a_supply(file: Path) -> None:
    """A closed chamber next to a pressurised one: pₐ (V₀/V − 1) at each stop, told in columns."""
    ratios = {"cavity": {}, "cavity_2": {"closed": True}, "cavity_3": {"pressure_ratio": 0.0}}
    result = run("bending", settings(file, ratios), comm=MPI.COMM_SELF)
    assert result.failure is None
    volume, pressure = result["cavity_2_volume_mm3"], result["cavity_2_pressure_kPa"]
    expected = 101.325 * (volume[0] / volume - 1)
    print(pressure, expected)
    assert abs(expected[-1]) > 0.01
    np.testing.assert_allclose(pressure, expected, rtol=1e-6, atol=1e-9)


def test_a_rotation_in_space_has_whole_turns() -> None:
    """Half a finger that is curled by hand: beyond half a turn, and beyond a whole one."""
    finger = small.model(small.short(), plate=False)
    model = finger.model
    space = model.u.function_space
    length = float(space.tabulate_dof_coordinates()[:, 2].max())
    turned = TipRotation(model, Slices(model))
    lean = np.radians(180.0)  # towards −x, in the plane of symmetry
    for degrees in (30.0, 170.0, 250.0, 400.0):

        def curl(x: np.ndarray, degrees: float = degrees) -> np.ndarray:
            bend = np.radians(degrees) * x[2] / length
            radius = length / np.radians(degrees)
            way = np.array([np.cos(lean), np.sin(lean)])
            along = x[0] * way[0] + x[1] * way[1]
            across = -x[0] * way[1] + x[1] * way[0]
            out = radius * (1 - np.cos(bend)) + along * np.cos(bend)
            up = radius * np.sin(bend) - along * np.sin(bend)
            now = np.array([out * way[0] - across * way[1], out * way[1] + across * way[0], up])
            return now - x

        model.u.interpolate(curl)
        found = turned.values()
        print(degrees, found)
        assert found["bending_angle_deg"] == pytest.approx(degrees, abs=0.5)
        assert found["tip_rotation_deg"] == pytest.approx(degrees, abs=0.5)
        assert found["tip_rotation_y_deg"] == pytest.approx(-degrees, abs=0.5)
        assert found["bending_direction_deg"] == pytest.approx(0.0, abs=0.5)


def test_bending_is_the_angle_in_the_plane_of_symmetry() -> None:
    result = run("bending", small.short("experiment.step_kPa=25"), comm=MPI.COMM_SELF)
    np.testing.assert_allclose(result["bending_angle_deg"], result["angle_deg"], atol=1e-9)
    np.testing.assert_allclose(-result["tip_rotation_y_deg"], result["angle_deg"], atol=1e-9)
    assert (result["tip_y_mm"] == 0).all()
    single = result.facts.mesh.single_walls
    assert 0.5 < single < 1
    assert list(doubts.of_run(result, single)) == []
    linear = replace(result, config=result.config.changed(solver={"element": "P1"}))
    (told,) = doubts.of_run(linear, single)
    assert "reach through its wall" in told.sentence


def test_a_finger_that_bends_backwards_and_walls_that_touch_are_told() -> None:
    """Walls touch where contact is felt: soft ones stay near the barrier's 0.2 mm."""
    config = small.short()
    row = {"pressure_kPa": 10.0, "angle_deg": -3.0, "bending_angle_deg": 3.0,
           "bending_direction_deg": 180.0, "wall_gap_mm": 0.19}  # fmt: skip
    rest = dict.fromkeys(row, 0.0) | {"wall_gap_mm": 0.21}
    told = list(doubts.of_motion(Readings("bending", config, [rest, row])))
    assert [each.title for each in told] == ["direction of bending", "walls inside"]
    assert "the angle is -3.0°" in told[0].sentence
    assert "touch one another from 10 kPa on" in told[1].sentence

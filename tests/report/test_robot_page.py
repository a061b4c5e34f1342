"""A reduced model on a page: beside finite elements, its speed, and the lines that load it."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.files.robot import (
    FreeShape,
    Joint,
    JointCoordinate,
    Link,
    QuantityError,
    RobotFile,
    Speed,
    Validity,
)
from dolfingrip.report.page import chain_scene, sources
from dolfingrip.report.page.scene import UPRIGHT
from dolfingrip.robot.control import BLUE, PALE, RED, JointLaws
from dolfingrip.robot.write import measured_speed


def write_robot(folder: Path, measured: Speed | None) -> None:
    """A chain of two links whose angle is 0.1° low at the second of two pressures."""
    one = Link(
        mass_kg=0.01, centre_mm=(8.0, 0.0, 20.0), inertia_kg_mm2=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0),
        section_mm=((0.0, -10.0), (16.0, -10.0), (16.0, 10.0), (0.0, 10.0)), from_mm=0.0,
        to_mm=40.0,
    )  # fmt: skip
    angle = QuantityError(
        quantity="angle", unit="deg", gap_mm=None, pressure_kPa=(10.0, 20.0),
        finite_elements=(1.0, 2.0), chain=(1.0, 1.9), rms=0.0707, largest=0.1, relative=0.05,
    )  # fmt: skip
    bend = JointCoordinate(
        name="bend_1", kind="hinge", axis=(0.0, -1.0, 0.0), law=(1.0, 0.0, -1.0, 0.0), damping_s=0.0
    )
    joint = Joint(place_mm=(8.0, 0.0, 40.0), coordinates=(bend,))
    RobotFile(
        config={}, links=(one, one), joints=(joint,),
        tip_mm=(8.0, 0.0, 80.0), pressing_mm=(), facing_plate=0, plate_N_per_mm=1.0, line_s=0.02,
        shape_error_mm=0.1, valid=Validity(pressure_kPa=(-5.0, 25.0), force_N=1.0, gaps_mm=(1.0,)),
        comparisons=(angle,), simulated_s=1.0, speed=measured,
    ).write(folder)  # fmt: skip


def test_what_the_page_has(tmp_path: Path) -> None:
    write_robot(tmp_path, Speed(times_real_time=54.6, step_s=0.001, mujoco="4.0.0"))
    page = sources.build(sources.find([tmp_path]))
    (chart,) = page.charts
    theirs, ours = chart.series
    assert (list(theirs.y), list(ours.y)) == ([1.0, 2.0], [1.0, 1.9])
    assert chart.below is not None
    np.testing.assert_allclose(chart.below.series[0].y, [0.0, -0.1])
    assert chart.note.endswith("Error: 0.0707° rms, 0.1° at most.")
    numbers = {each.name: (each.value, each.said) for each in page.numbers}
    assert numbers["Speed in MuJoCo"] == (
        "55 × real time", "one finger, steps of 1 ms, one core"
    )  # fmt: skip
    assert numbers["Error: angle, free"][0] == "0.0707° rms"
    ((title, lines),) = page.code
    assert title == "In MuJoCo"
    assert f"MjModel.from_xml_path({str(tmp_path / 'finger.xml')!r})" in lines
    assert ".ctrl = 25\n" in lines  # the highest fitted pressure
    (source,) = page.sources
    assert source.again == f"dolfingrip robot {tmp_path / 'robot.json'}"


def test_the_chain_stands_beside_the_finite_elements_in_3d(tmp_path: Path) -> None:
    """A quarter turn: a section's points lie where its motion puts them; a link stays rigid."""
    write_robot(tmp_path, None)
    one = RobotFile.read(tmp_path)
    turn = np.pi / 2
    rest = FreeShape(
        pressure_kPa=0.0, finite_elements=((0, 0, 0), (0, 80, 0)), chain=((0, 0, 0), (0, 40, 0))
    )
    bent = FreeShape(
        pressure_kPa=25.0, finite_elements=((0, 0, 0), (-50, 50, turn)),
        chain=((0, 0, 0), (-5, 45, turn)),
    )  # fmt: skip
    other = one.links[0].model_copy(update={"from_mm": 40.0, "to_mm": 80.0})
    shown = {"levels_mm": (0, 80), "shapes": (rest, bent), "links": (one.links[0], other)}
    scene = chain_scene.scene_of(one.model_copy(update=shown))
    (theirs, ours), (at_rest, _, last) = scene.parts, scene.parts[0].frames * UPRIGHT
    assert list(scene.load.values) == [0.0, 25.0]
    np.testing.assert_allclose(at_rest.min(axis=0), [0, -10, 0])
    np.testing.assert_allclose(at_rest.max(axis=0), [16, 10, 80])
    # the tip's section is level: x of the outline points along z
    np.testing.assert_allclose(last[-4:, 0], -50, atol=1e-12)
    np.testing.assert_allclose(last[-4:, 2], [50, 66, 66, 50])
    first, _, end = ours.frames * UPRIGHT
    between = [np.linalg.norm(each[8:, None] - each[None, 8:], axis=2) for each in (first, end)]
    np.testing.assert_allclose(*between)  # of the second link, all distances stay
    np.testing.assert_allclose(end[8:].max(axis=0) - end[8:].min(axis=0), [40, 20, 16])
    assert first[:, 0].min() > max(at_rest[:, 0].max(), last[:, 0].max())
    for part in scene.parts:  # closed surfaces that look outwards
        a, b, c = (part.frames[0][part.skin.triangles[:, i]] for i in range(3))
        volume = np.einsum("ni,ni->", a, np.cross(b, c)) / 6
        assert volume == pytest.approx(16 * 20 * 80)
    assert theirs.skin.points.shape == theirs.frames[0].shape
    one.model_copy(update=shown).write(tmp_path)
    assert len(sources.build(sources.find([tmp_path])).scenes) == 1


def test_without_mujoco_nothing_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert measured_speed("<mujoco/>") is None
    write_robot(tmp_path, None)
    page = sources.build(sources.find([tmp_path]))
    assert page.numbers[0].value == "–"
    assert page.numbers[0].verdict == "open"


def test_the_colour_goes_with_the_pressure(tmp_path: Path) -> None:
    write_robot(tmp_path, None)
    finger = JointLaws(tmp_path / "robot.json")
    for pressure, colour in ((0.0, PALE), (25.0, RED), (99.0, RED), (-25.0, BLUE)):
        np.testing.assert_allclose(finger.colour(pressure), colour)
    np.testing.assert_allclose(finger.colour(12.5), (PALE + RED) / 2)

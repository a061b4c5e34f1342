"""A reduced model on a page: beside finite elements, its speed, and the lines that load it."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.files.robot import (
    Joint,
    JointCoordinate,
    Link,
    QuantityError,
    RobotFile,
    Speed,
    Validity,
)
from dolfingrip.report.page import sources
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

"""The pictures of a grasp: its film, their labels, and its fields with food and table."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
import pyvista as pv

from dolfingrip.experiments.rigs.food import grasped
from dolfingrip.foods.food import Food
from dolfingrip.report.fields import list_steps
from dolfingrip.report.gripper import (
    FRAME_MS,
    Moment,
    label,
    stages,
    write_scene,
)
from dolfingrip.report.skin import Skin
from dolfingrip.report.video import POLICY, labelled, write


def test_a_film_shows_each_picture(tmp_path: Path) -> None:
    """Grey levels come back in order, one column less of an odd width."""
    levels = [20, 120, 220]
    files = write(
        tmp_path / "film", [np.full((48, 65, 3), at, np.uint8) for at in levels], FRAME_MS
    )
    assert [file.suffix for file in files] == [".gif", ".mp4"]
    with av.open(str(tmp_path / "film.mp4")) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.average_rate == 1000 / FRAME_MS
        found = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    assert [image.shape for image in found] == 3 * [(48, 64, 3)]
    for image, level in zip(found, levels, strict=True):
        assert abs(float(image.mean()) - level) < 5


def test_the_stages_of_a_grasp() -> None:
    """The start, half-way, where the fingers are closed, and the end of the lift."""
    assert stages(["loading"] * 7 + ["hold"] * 4) == [0, 3, 6, 10]
    assert stages(["loading"] * 2 + ["hold"]) == [0, 1, 2]
    assert stages(["loading"]) == [0]


def test_a_picture_says_time_and_pressure() -> None:
    assert label(0.0, -0.0, "loading") == "0.00 s, 0 kPa, at rest"
    assert label(2.5, 100.0, "hold") == "2.50 s, 100 kPa, holding"
    assert label(3.17, 100.0, "lift") == "3.17 s, 100 kPa, lifting"


@pytest.mark.parametrize("width", [800, 160])
def test_a_label_stands_above_the_picture_and_is_whole(width: int) -> None:
    image = np.full((40, width, 3), 255, np.uint8)
    found = labelled(image, label(3.17, 234.4, "lift"))
    assert found.shape == (40 + 2 * POLICY.label_px, width, 3)
    inked = np.flatnonzero((found[:-40] < 128).any(axis=(0, 2)))
    assert inked.size > 30
    assert inked[0] > 0
    assert inked[-1] < width - 1
    assert (found[-40:] == 255).all()


def test_fields_have_fingers_food_and_table(tmp_path: Path) -> None:
    """The table stands still at z = 0; food on it begins there, lifted food above it."""
    points = np.array([[0.0, 0, 20], [9, 0, 20], [0, 9, 20], [0, 0, 90]])
    triangles = np.array([[0, 1, 2], [0, 1, 3]])
    none = np.zeros((0, 2), dtype=int)
    skin = Skin(points, np.arange(4), np.array([0.0, 0, 1, 2]), triangles, none, none)
    body = grasped(Food())
    placed = body.surface.points + np.array(body.body.centre_mm)
    moved, stretch = np.full((4, 3), 0.5), np.full(4, 1.25)
    moments = [
        Moment(points, placed, 0.0, moved, {"stretch": stretch}, 0.0, ""),
        Moment(points, placed, -30.0, moved, {"stretch": stretch}, 3.5, ""),
    ]
    write_scene(tmp_path / "grasp.pvd", skin, body, moments)
    files = list_steps(tmp_path / "grasp.pvd")
    assert len(files) == 2 * 3
    assert 'timestep="3.5" part="2"' in (tmp_path / "grasp.pvd").read_text(encoding="utf-8")
    first, food, table, _, lifted, _ = (pv.read(file) for file in files)
    assert np.asarray(first["displacement_mm"]) == pytest.approx(moved)
    assert np.asarray(first["principal_stretch"]) == pytest.approx(stretch)
    assert table.bounds[5] == pytest.approx(0.0)
    assert food.bounds[4] == pytest.approx(0.0, abs=1e-5)
    assert lifted.bounds[4] == pytest.approx(30.0, abs=1e-5)

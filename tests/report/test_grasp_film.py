"""The pictures of a grasp: its film, their labels, and its fields with food and table."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
import pyvista as pv
from PIL import Image as Pillow
from support import small

from dolfingrip.experiments.results.fields import FieldFile
from dolfingrip.experiments.rigs.food import grasped
from dolfingrip.experiments.rigs.gripper import build_gripper
from dolfingrip.foods.food import Food
from dolfingrip.report.drawers import WantedPictures
from dolfingrip.report.gripper import (
    FILM_S,
    VIEW,
    GraspFrame,
    draw,
    filmed,
    label,
    moments_of,
    stages,
    write_scene,
)
from dolfingrip.report.skin import Skin
from dolfingrip.report.video import POLICY, labelled, titled, write


def test_a_film_shows_each_picture(tmp_path: Path) -> None:
    """Grey levels come back in order, one column less of an odd width."""
    levels = [20, 120, 220]
    files = write(tmp_path / "film", [np.full((48, 65, 3), at, np.uint8) for at in levels])
    assert [file.suffix for file in files] == [".gif", ".mp4"]
    with av.open(str(tmp_path / "film.mp4")) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.average_rate == 1000 / POLICY.frame_ms
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
        GraspFrame(points, placed, 0.0, moved, {"stretch": stretch}, 0.0, ""),
        GraspFrame(points, placed, -30.0, moved, {"stretch": stretch}, 3.5, ""),
    ]
    write_scene(tmp_path / "grasp.pvd", skin, body, moments)
    text = (tmp_path / "grasp.pvd").read_text(encoding="utf-8")
    files = [tmp_path / name for name in re.findall(r'file="([^"]+)"', text)]  # for ParaView alone
    assert len(files) == 2 * 3
    assert 'timestep="3.5" part="2"' in text
    first, food, table, _, lifted, _ = (pv.read(file) for file in files)
    assert np.asarray(first["displacement_mm"]) == pytest.approx(moved)
    assert np.asarray(first["principal_stretch"]) == pytest.approx(stretch)
    assert table.bounds[5] == pytest.approx(0.0)
    assert food.bounds[4] == pytest.approx(0.0, abs=1e-5)
    assert lifted.bounds[4] == pytest.approx(30.0, abs=1e-5)


def test_a_film_has_the_field_that_it_shows() -> None:
    """Values between two rows are between theirs, as long as is asked for; others are left out."""
    moments = [
        replace(each, fields={"stretch": np.full(3, 1 + each.time_s), "mises": np.zeros(3)})
        for each in moments_at([0.0, 1.0, 2.0])
    ]
    result = {"pressure_kPa": [0.0, 50.0, 100.0], "branch": ["loading"] * 3}
    film = filmed(moments, result, 5.0, ["stretch"])
    assert len(film) == 1 + 5 * 25
    for each in film:
        assert set(each.fields) == {"stretch"}
        assert each.fields["stretch"] == pytest.approx(1 + each.time_s)


def moments_at(times_s: list[float]) -> list[GraspFrame]:
    """Fingers and food that move by 3 mm/s along x, while the table goes down by 10 mm/s."""
    still = np.array([[0.0, 0, 20], [9, 0, 20], [0, 9, 20]])
    way = np.array([3.0, 0, 0])
    return [
        GraspFrame(still + t * way, still + t * way, -10 * t, still, {}, t, "") for t in times_s
    ]


def test_a_film_is_smooth_between_the_rows() -> None:
    """Uniform motion of rows at uneven times stays uniform; stages and pressures are theirs."""
    times = [0.0, 1.0, 1.0, 1.5, 4.0]  # a wait of no length
    result = {
        "pressure_kPa": [0.0, 100.0, 100.0, 100.0, 100.0],
        "branch": ["loading", "loading", "hold", "hold", "lift"],
    }
    film = filmed(moments_at(times), result)
    steps_s = np.diff([each.time_s for each in film])
    assert steps_s == pytest.approx(0.04)  # 25 pictures a second, in real time
    for each in film:
        assert each.skin[0, 0] == pytest.approx(3 * each.time_s)
        assert each.food[0, 0] == pytest.approx(3 * each.time_s)
        assert each.table_mm == pytest.approx(-10 * each.time_s)
    assert film[0].label == "0.00 s, 0 kPa, at rest"
    assert "pressurising" in film[12].label
    assert film[30].label == "1.20 s, 100 kPa, holding"
    assert film[-1].label == "4.00 s, 100 kPa, lifting"


def test_a_short_grasp_is_slowed_and_a_long_one_quickened() -> None:
    result = {"pressure_kPa": [0.0, 50.0], "branch": ["loading", "loading"]}
    for lasts_s, seconds in ((0.5, FILM_S[0]), (60.0, FILM_S[1])):
        film = filmed(moments_at([0.0, lasts_s]), result)
        assert len(film) == 1 + seconds * 1000 / POLICY.frame_ms


def test_the_words_of_a_film_stand_still() -> None:
    """Ink begins in the same column, and so do the words after numbers of other widths."""
    image = np.full((40, 900, 3), 255, np.uint8)
    texts = ["9.99 s, 8 kPa, lifting", "10.00 s, 150 kPa, lifting"]
    found = titled([image] * 2, texts)
    tops = [(each[:-40] < 128).any(axis=2) for each in found]
    ends = [np.flatnonzero(top.any(axis=0)) for top in tops]
    assert ends[0][-1] == ends[1][-1]
    tail = slice(ends[0][-1] - 80, None)
    assert (tops[0][:, tail] == tops[1][:, tail]).all()


def test_a_gif_is_small_enough_to_send(tmp_path: Path) -> None:
    """Noise, which nothing packs: pictures are left out, and the film lasts as long."""
    seed = 3
    print("seed", seed)
    images = list(np.random.default_rng(seed).integers(0, 255, (16, 80, 80, 3), np.uint8))
    write(tmp_path / "film", images, replace(POLICY, gif_bytes=14_000))
    assert (tmp_path / "film.gif").stat().st_size <= 14_000
    with Pillow.open(tmp_path / "film.gif") as film:
        assert 1 < film.n_frames < 16
        assert film.n_frames * film.info["duration"] == 16 * POLICY.frame_ms


@pytest.mark.slow
@pytest.mark.parametrize("half", [True, False])
def test_a_cut_gripper_has_half_of_each_finger(half: bool, tmp_path: Path) -> None:
    """Each by its own mid plane, cut face towards the camera; chamber walls have the pressure."""
    asked = small.short().changed(
        mesh={"half": False}, gripper={"half": half, "pose": "claw"}, food={"kind": "strawberry"}
    )
    gripper = build_gripper(asked, small.SELF)
    gripper.finger.cavity.set(30.0)
    fields = FieldFile(gripper.model, tmp_path / "fields.pvd", gripper.finger.pressures)
    fields.write(0.0)
    body = grasped(asked.food)
    row = {f"object_{what}": [0.0] for what in ("turn_x_deg", "turn_y_deg", "turn_z_deg")}
    row |= {f"object_{axis}_mm": [at] for axis, at in zip("xyz", body.body.centre_mm, strict=True)}
    row |= {"table_z_mm": [0.0], "time_s": [0.0], "pressure_kPa": [30.0]}
    result: dict[str, list[Any]] = {**row, "branch": ["loading"]}
    found = [moments_of(tmp_path / "fields.pvd", asked, result, body, cut) for cut in (None, VIEW)]
    volumes = []
    for skin, (moment,) in found:
        for finger in range(3):
            mine = skin.triangles[skin.side[skin.triangles[:, 0]] == finger]
            a, b, c = (moment.skin[mine[:, i]] for i in range(3))
            volumes.append(float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6))
    assert volumes[3:] == pytest.approx([each / 2 for each in volumes[:3]], rel=1e-6)
    skin, (moment,) = found[1]
    walls = skin.on_walls(moment.fields["pressure"], 0.0)
    assert walls == pytest.approx(np.where(walls > 0, 30.0, 0.0))
    assert 0.1 < (walls > 0).mean() < 0.9
    files = draw(tmp_path, asked, result, WantedPictures("pressure", cut=True, video=False))
    assert [file.name for file in files] == ["grasp.png"]

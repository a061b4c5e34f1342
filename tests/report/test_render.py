"""Pictures: made, sized, not blank, and comparable with one another."""

from __future__ import annotations

import shutil
from itertools import pairwise, product
from pathlib import Path

import av
import matplotlib.image
import numpy as np
import numpy.typing as npt
import pytest
from matplotlib.colors import rgb_to_hsv
from PIL import Image

from dolfingrip.channels import ANGLE, PRESSURE
from dolfingrip.charts.theme import colour_map
from dolfingrip.config import Config
from dolfingrip.files.table import read_csv
from dolfingrip.report.beside import Beside, Plate
from dolfingrip.report.layout import around
from dolfingrip.report.render import SIDE, draw, draw_video
from dolfingrip.report.scene import framing
from dolfingrip.report.video import POLICY

Pixels = npt.NDArray[np.float64]


def _read(file: Path) -> Pixels:
    return np.asarray(matplotlib.image.imread(file)[..., :3], dtype=np.float64)


def _coloured(picture: Pixels) -> npt.NDArray[np.bool_]:
    """Pixels with a hue: the finger and the colour scale, not fixtures or lettering."""
    return np.ptp(picture, axis=2) > 0.08


def test_poses_share_camera_and_frame(run: Path, tmp_path: Path) -> None:
    drawn = draw(run / "fields.pvd", [0, 100, 200], height_in=2.0)
    files = drawn.save_each(tmp_path / "new")
    assert [file.name for file in files] == [
        "finger_0kPa.png",
        "finger_100kPa.png",
        "finger_200kPa.png",
    ]
    pictures = [_read(file) for file in files]
    assert len({picture.shape for picture in pictures}) == 1
    height, width, _ = pictures[0].shape
    assert 800 < height < 1000
    assert width > 400
    clamp = slice(int(0.13 * height), int(0.18 * height)), slice(0, int(0.35 * width))
    assert pictures[0][clamp].std() > 0.02
    for picture in pictures[1:]:
        np.testing.assert_array_equal(picture[clamp], pictures[0][clamp])
        lower = slice(int(0.4 * height), int(0.8 * height)), slice(0, int(0.7 * width))
        assert np.abs(picture[lower] - pictures[0][lower]).mean() > 0.02
    assert _coloured(pictures[2]).mean() > 0.05


def test_finger_bends_to_the_right(run: Path, tmp_path: Path) -> None:
    straight, bent = (
        _coloured(_read(file))[:, :-330]  # without the colour scale
        for file in draw(run / "fields.pvd", [0, 200], height_in=2.0).save_each(tmp_path)
    )
    assert np.flatnonzero(bent.any(axis=0)).max() > 1.3 * np.flatnonzero(straight.any(axis=0)).max()


def test_strip_holds_all_poses(quadratic_run: Path, tmp_path: Path) -> None:
    fields = quadratic_run / "fields.pvd"
    one = _read(draw(fields, [100], height_in=2.0).save_strip(tmp_path / "one.png"))
    three = _read(
        draw(
            fields,
            [0, 100, 200],
            height_in=2.0,
            colour_by="stretch",
            beside=Beside(Plate((0.0, 0.0, 0.0))),
        ).save_strip(tmp_path / "three.png")
    )
    assert three.shape[1] > 1.5 * one.shape[1]
    assert len(np.unique((three * 255).astype(int).reshape(-1, 3), axis=0)) > 500
    edge = np.concatenate([three[:, :4].ravel(), three[:, -4:].ravel(), three[-4:].ravel()])
    assert (edge > 0.98).all()  # nothing is clipped by the border


def test_an_obstacle_stands_beside_the_finger(quadratic_run: Path) -> None:
    """Its surface touches the back at rest where its gap is 0; it takes colour and widens all."""
    obstacle = {"kind": "sausage-short", "gap_mm": 0.0, "barrier_mm": 0.1, "z_mm": 50.0}
    beside = Beside.of_run(Config().changed(obstacle=obstacle), None)
    assert beside.food is not None
    assert beside.food.points[:, 0].max() == pytest.approx(-0.1, abs=1e-9)
    low, high = beside.food.points.min(axis=0), beside.food.points.max(axis=0)
    np.testing.assert_allclose((low + high)[1:] / 2, [0.0, 50.0], atol=0.05)
    fields = quadratic_run / "fields.pvd"
    alone, both = (
        draw(fields, [0], height_in=1.0, beside=each).images[0] for each in (Beside(), beside)
    )
    yellow = [((each[..., 0] > 200) & (each[..., 2] < 130)).mean() for each in (alone, both)]
    assert yellow[1] > yellow[0] + 0.03
    assert both.shape[1] > 1.2 * alone.shape[1]


def test_section_shows_the_cut(quadratic_run: Path, tmp_path: Path) -> None:
    drawn = draw(
        quadratic_run / "fields.pvd", [0, 200], shown="section", colour_by="stretch", height_in=2.0
    )
    picture = _read(drawn.save_strip(tmp_path / "cut.png"))
    assert _coloured(picture).mean() > 0.05


def test_unloading_and_given_columns(quadratic_run: Path, tmp_path: Path) -> None:
    pressures = [0.0, 50.0, 100.0, 150.0, 200.0, 150.0, 100.0, 50.0, 0.0]
    result = {"pressure_kPa": pressures, "branch": ["loading"] * 5 + ["unloading"] * 4}
    for branch in ("loading", "unloading"):
        draw(
            quadratic_run / "fields.pvd", [100], result=result, branch=branch, height_in=1.0
        ).save_each(tmp_path, branch)
    loading, unloading = (_read(tmp_path / f"{b}_100kPa.png") for b in ("loading", "unloading"))
    assert loading.shape != unloading.shape or (loading != unloading).any()


def test_a_video_lasts_ten_seconds_and_says_what_it_shows(
    quadratic_run: Path, tmp_path: Path
) -> None:
    """Its pictures pass through those of the readings, and the labels through their numbers."""
    fields = quadratic_run / "fields.pvd"
    drawn = draw_video(fields, [PRESSURE, ANGLE], seconds=0.68)  # 17 pictures of 9 readings
    pressures = [0.0, 50.0, 100.0, 150.0, 200.0]
    table = read_csv(quadratic_run / "result.csv")
    angles = np.asarray(table["angle_deg"], dtype=float)
    said = [f"{p:.1f} kPa, {a:.1f}°" for p, a in zip(pressures, angles[:5], strict=True)]
    assert drawn.labels[:9:2] == said
    assert drawn.labels[1].startswith("25.0 kPa")
    still = draw(fields, pressures, height_in=POLICY.height_px / 300)
    assert drawn.range_ == still.range_
    for one, other in zip(drawn.images[:9:2], still.images, strict=True):
        # shapes between readings reach a little farther, so the frame is another one
        assert one.mean() == pytest.approx(other.mean(), abs=1)
    steps = [np.abs(a.astype(int) - b).mean() for a, b in pairwise(drawn.images[:9])]
    assert min(steps) > 0.5  # it moves between readings, too
    moving, film = drawn.save_video(tmp_path / "video")
    with Image.open(moving) as image:
        assert (image.n_frames, image.info["duration"]) == (17, 40)  # type: ignore[attr-defined]
    with av.open(str(film)) as container:
        assert container.streams.video[0].frames == 17


def test_the_camera_turns_about_a_point_that_stays(quadratic_run: Path) -> None:
    """A turned film has one scale, no axes, and the usual view in its middle."""
    views = SIDE.turning(40.0, 3)
    assert [each.azimuth_deg for each in views] == pytest.approx([12.0, 32.0, 52.0])
    ends = np.array([[0.0, -8, 0], [16, 8, 90]])
    box = np.array([[x, y, z] for x, y, z in product(*ends.T)])
    focuses, size_mm, _ = framing([box] * 3, views)
    centre = ends.mean(axis=0)
    for view, focus in zip(views, focuses, strict=True):
        right, up, _ = view.axes
        seen = (box - focus) @ np.array([right, up]).T
        assert (np.abs(seen).max(axis=0) < size_mm / 2 + 1e-6).all()
        assert (centre - focus) @ right == pytest.approx((centre - focuses[0]) @ views[0].axes[0])
    drawn = draw_video(quadratic_run / "fields.pvd", [PRESSURE], seconds=0.2, turn_deg=30.0)
    assert drawn.view is None
    assert len({image.shape for image in drawn.images}) == 1
    still = draw_video(quadratic_run / "fields.pvd", [PRESSURE], seconds=0.2)
    assert still.view == SIDE
    assert still.images[0].shape[1] != drawn.images[0].shape[1]


@pytest.mark.parametrize(
    ("px_per_mm", "length_mm"), [(8.8, 20.0), (14.0, 10.0), (0.5, 500.0), (300.0, 0.5)]
)
def test_the_scale_bar_suits_the_part(px_per_mm: float, length_mm: float) -> None:
    """A slim specimen, a part of a metre and one of a millimetre: no picture is wider than it."""
    slim = np.full((300, 60, 3), 255, np.uint8)
    drawn, _ = around(
        slim, px_per_mm=px_per_mm, view=None, colour_map=colour_map("none"), range_=(0.0, 1.0),
        scale_label="",
    )  # fmt: skip
    dark = (drawn < 128).all(axis=2)
    bar = dark[dark.sum(axis=1).argmax()].nonzero()[0]
    assert np.ptp(bar) == pytest.approx(length_mm * px_per_mm, abs=3)
    assert drawn.shape[1] == pytest.approx(length_mm * px_per_mm + 60, abs=3)


def test_nothing_colours_a_finger(quadratic_run: Path, tmp_path: Path) -> None:
    """It has one hue, and no scale stands beside it."""
    fields = quadratic_run / "fields.pvd"
    plain, coloured = (
        draw(fields, [200], colour_by=each, height_in=1.0) for each in ("none", "displacement")
    )
    alone, beside = (
        _read(each.save_strip(tmp_path / f"{each.colour_by}.png")) for each in (plain, coloured)
    )
    assert alone.shape[1] < beside.shape[1] - 200
    hues = [rgb_to_hsv(each)[_coloured(each), 0] for each in (alone, beside)]
    assert np.ptp(hues[0]) < 0.05
    assert np.ptp(hues[1]) > 0.2


def test_a_run_that_was_killed_between_fields_and_row(quadratic_run: Path) -> None:
    """Its fields have a step more than its table has rows."""
    table = read_csv(quadratic_run / "result.csv")
    rows = {name: entries[:-1] for name, entries in table.items()}
    whole, cut = (draw(quadratic_run / "fields.pvd", [50], result=each, height_in=1.0)
                  for each in (table, rows))  # fmt: skip
    np.testing.assert_array_equal(whole.images[0], cut.images[0])


def test_bad_questions_are_answered_in_one_line(quadratic_run: Path, tmp_path: Path) -> None:
    fields = quadratic_run / "fields.pvd"
    with pytest.raises(ValueError, match=r"^pressure_kPa = 33: .*allowed: 0, 50, 100, 150, 200$"):
        draw(fields, [33])
    with pytest.raises(ValueError, match=r"^colour_by = strain: allowed: displacement, stretch,"):
        draw(fields, [0], colour_by="strain")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"no mises; allowed: stretch, displacement, none$"):
        draw(fields, [0], colour_by="mises")
    with pytest.raises(ValueError, match="9 steps, but the result has 2 rows"):
        draw(fields, [0], result={"pressure_kPa": [0, 50]})
    with pytest.raises(ValueError, match="at least one pressure"):
        draw(fields, [])
    copy = tmp_path / "no_result"
    copy.mkdir()
    shutil.copy(fields, copy)
    with pytest.raises(ValueError, match=r"result\.csv: No such file"):
        draw(copy / "fields.pvd", [0])

"""A finger without marks, drawn as a bent bar in front of the sheet, by a camera that is known.

The bar's turn along its back is not that of any shape which starts the search: it bends more near
the tip. So what is read must come from the picture's edges.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from support.command import run_command
from support.filmed import Filmed, write

from dolfingrip.config import ConfigError, load
from dolfingrip.tracking import body, edges, family, scale, show, watch
from dolfingrip.tracking.asked import TrackAsked
from dolfingrip.tracking.frames import Frame

SIZE_MM = (14.0, 16.0, 62.0)
"""Depth, width and length of the bar."""
STATIONS = np.linspace(0.0, 1.0, 125)
GREY = (110, 105, 100)


def skin(turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles of a bar whose back turns (stations,) from z towards −x."""
    across = np.linspace(-0.5, 0.5, 5) * SIZE_MM[1]
    deep = np.linspace(0.0, 1.0, 6) * SIZE_MM[0]
    grid = np.stack(np.meshgrid(deep, across, STATIONS, indexing="ij"), axis=-1).reshape(-1, 3)
    steps = np.diff(STATIONS, prepend=0.0)[:, None] * SIZE_MM[2]
    line = np.cumsum(steps * np.column_stack([-np.sin(turn), np.cos(turn)]), axis=0)
    x, z, bend = (np.interp(grid[:, 2], STATIONS, each) for each in (*line.T, turn))
    points = np.column_stack([x + grid[:, 0] * np.cos(bend), grid[:, 1],
                              z + grid[:, 0] * np.sin(bend)])  # fmt: skip
    number = np.arange(len(grid)).reshape(len(deep), len(across), len(STATIONS))
    faces = [number[0], number[-1][::-1], number[:, 0][::-1], number[:, -1],
             number[:, :, 0], number[:, :, -1][::-1]]  # fmt: skip
    quads = np.concatenate([
        np.stack([f[:-1, :-1], f[1:, :-1], f[1:, 1:], f[:-1, 1:]], axis=-1).reshape(-1, 4)
        for f in faces
    ])  # fmt: skip
    return points, np.concatenate([quads[:, [0, 2, 1]], quads[:, [0, 3, 2]]])


def simulated_turn(bend_deg: float) -> np.ndarray:
    return np.radians(bend_deg) * STATIONS


def true_turn(bend_deg: float) -> np.ndarray:
    return np.radians(bend_deg) * STATIONS**1.6


def frame(
    camera: Filmed, points: np.ndarray, triangles: np.ndarray, seed: int = 0, post: bool = False
) -> np.ndarray:
    """A picture of a skin, bending to the right; a post may stand in front of it."""
    solid = np.column_stack([-points[:, 0], points[:, 2], points[:, 1] - camera.front_mm])
    lens = np.array([camera.k1, 0, 0, 0])
    px = cv2.projectPoints(solid, camera.turn, camera.place, camera.matrix, lens)[0].reshape(-1, 2)
    image = camera.background.copy()
    cover = np.zeros(image.shape[:2], np.uint8)
    fine = np.round((px[triangles] + 0.5) * 4 * 16 - 8).astype(np.int32)
    large = np.zeros((4 * cover.shape[0], 4 * cover.shape[1]), np.uint8)
    for corners in fine:
        cv2.fillConvexPoly(large, corners, 255, shift=4)
    cover = cv2.resize(large, cover.shape[::-1], interpolation=cv2.INTER_AREA)
    share = cover[..., None] / 255
    image = image * (1 - share) + np.array(GREY) * share
    if post:
        image[:, 520:528] = 40
    grain = np.random.default_rng(seed).normal(0, 2.0, image.shape)
    return np.clip(np.round(image + grain), 0, 255).astype(np.uint8)


class Frames:
    """Images as a source of frames."""

    name = "film"

    def __init__(self, images: list[np.ndarray], rate_hz: float) -> None:
        self._images, self._rate_hz, self.expected = images, rate_hz, len(images)

    def __iter__(self):
        for i, image in enumerate(self._images):
            yield Frame(i, i / self._rate_hz, image, f"{i}")


@pytest.fixture(scope="module")
def shapes() -> family.Family:
    skins = [skin(simulated_turn(bend)) for bend in np.linspace(0, 70, 8)]
    return family.of_skins(np.array([points for points, _ in skins]), skins[0][1])


def read(
    images: list[np.ndarray], shapes: family.Family, camera: Filmed, out: Path, rate_hz: float
) -> body.Body:
    asked = TrackAsked(family=shapes, in_front_mm=camera.front_mm)
    source = Frames(images, rate_hz)
    try:
        seen = watch.watch(source, asked, lambda done, total: None)
    except ConfigError as error:
        raise show.refusal(error, source, None, out) from None
    assert len(seen.outlines) == len(images)
    calibration = scale.calibrate(seen, asked, SIZE_MM[1] / 2)
    return body.read(seen.points, calibration, None, None)


def places(turn: np.ndarray, count: int) -> np.ndarray:
    """True x and z (count, 2) of the points that divide the back equally."""
    line = skin(turn)[0].reshape(6, 5, len(STATIONS), 3)[0, 2][:, [0, 2]]
    shares = np.arange(1, count + 1) / count
    return np.stack([np.interp(shares, STATIONS, line[:, i]) for i in (0, 1)], axis=1)


@pytest.mark.parametrize("rate_hz", [20.0, np.nan])
def test_the_back_is_read_where_it_bends_as_no_shape_does(
    shapes: family.Family, tmp_path: Path, rate_hz: float
) -> None:
    """A video, and pictures of which each is sought anew."""
    camera = Filmed(front_mm=9.0)
    bends = np.linspace(0, 56, 15 if np.isfinite(rate_hz) else 5)
    images = [frame(camera, *skin(true_turn(bend)), i) for i, bend in enumerate(bends)]
    found = read(images, shapes, camera, tmp_path, rate_hz)
    true = np.array([places(true_turn(bend), 5) for bend in bends])
    simulated = places(simulated_turn(56.0), 5)
    assert np.abs(simulated - true[-1]).max() > 3  # mm: the search starts from another shape
    arm = true[:, -1] - true[:, -2]
    angle = np.degrees(np.arctan2(-arm[:, 0], arm[:, 1]))
    off = found.readings["angle_deg"] - (angle - angle[0])
    assert np.sqrt((off**2).mean()) < 0.5
    for i in range(5):
        for k, axis in enumerate("xz"):
            away = found.readings[f"marker_{i + 1}_{axis}_mm"] - true[:, i, k]
            assert np.abs(away).max() < 0.5
    assert found.bends == "right"
    assert found.on_back


def test_what_a_post_hides_is_less_certain(shapes: family.Family, tmp_path: Path) -> None:
    """Where it crosses the tip, the error of the angle grows, and holds the truth."""
    camera, bends = Filmed(front_mm=9.0), np.linspace(0, 56, 12)
    images = [frame(camera, *skin(true_turn(bend)), i, post=True) for i, bend in enumerate(bends)]
    found = read(images, shapes, camera, tmp_path, 20.0)
    arm = np.array([np.diff(places(true_turn(bend), 5)[-2:], axis=0)[0] for bend in bends])
    off = found.readings["angle_deg"] - np.degrees(np.arctan2(-arm[:, 0], arm[:, 1]))
    spread = np.hypot(found.noise["angle_deg"], found.common["angle_deg"])
    assert (np.abs(off) < 3 * spread + 0.05).all()
    tip_px = np.array([camera.pixels(places(true_turn(b), 5)[-1:] * [-1, 1])[0, 0] for b in bends])
    hidden = np.abs(tip_px - 523) < 12
    assert 0 < hidden.sum() < 6
    assert spread[hidden].max() > 1.5 * np.median(spread)


def test_a_frame_without_such_an_outline_is_refused(shapes: family.Family, tmp_path: Path) -> None:
    camera = Filmed(front_mm=9.0)
    with pytest.raises(ConfigError, match=r"no outline .* is seen at rest: .*seen.png"):
        read([camera.background], shapes, camera, tmp_path, 20.0)


def test_an_edge_is_found_to_a_tenth_of_a_pixel() -> None:
    """Vertical edges at broken places of a row, between a finger of 80 and a sheet of 200."""
    for place in (20.0, 20.3, 20.7):
        share = np.clip(place + 0.5 - np.arange(40), 0, 1)
        row = 200 - 120 * share
        image = np.repeat(np.repeat(row[None, :, None], 20, axis=0), 3, axis=2).round()
        behind = np.full_like(image, 200.0).astype(np.uint8)
        at, normals = np.array([[18.0, 10.0]]), np.array([[1.0, 0.0]])
        inner = np.full((1, 3), 80.0)
        off, beside = edges.offsets(image.astype(np.uint8), behind, inner, at, normals, 8.0)
        assert off[0] + 18.0 == pytest.approx(place, abs=0.1)
        np.testing.assert_allclose(beside, 80, atol=3)


@pytest.mark.slow
def test_a_video_of_another_finger_than_the_simulated_one_is_read(tmp_path: Path) -> None:
    """The finger in the video has another mesh, and is stiffer near the clamp than near the tip."""
    camera = Filmed(front_mm=11.0)
    told = {"finger.length_mm": 62, "finger.bellows": 4, "mesh.size_mm": 8, "mesh.edge_size_mm": 8}
    hidden = {"mesh.size_mm": 6, "mesh.edge_size_mm": 6, "extensions.uneven_stiffness.a_1": 0.4}
    real = family.simulate(load(overrides={**told, **hidden}), lambda done, total: None)
    numbers = np.arange(real.back.min())
    none = np.zeros(real.waves.shape[1])
    states = np.linspace(0, 8, 15)
    skins = [real.places(state, none, 0.0, numbers) for state in states]
    images = [frame(camera, points, real.triangles, i) for i, points in enumerate(skins)]
    write(tmp_path / "film.mp4", images, 20.0)
    rows = [f"{i / 20},{10 * state}" for i, state in enumerate(states)]
    (tmp_path / "log.csv").write_text("\n".join(["time_s,pressure_kPa", *rows]))
    changes = [part for key, value in told.items() for part in ("--set", f"{key}={value}")]
    files = (tmp_path / "film.mp4", "--log", tmp_path / "log.csv", "--in-front", "11")
    assert run_command("track", *files, "--silhouette", *changes, "-o", tmp_path / "out") == 0
    frames = pd.read_csv(tmp_path / "out" / "film_frames.csv")
    at = [int(np.abs(real.stations_mm - part * 62).argmin()) for part in (0.8, 1.0)]
    arm = []
    for state in states:
        turn, stretch = real.between(real.turn, state), real.between(real.stretch, state)
        line = real.line(turn, stretch)
        arm.append(line[at[1]] - line[at[0]])
    angle = np.degrees(np.arctan2(-np.array(arm)[:, 0], np.array(arm)[:, 1]))
    assert angle.max() > 25
    assert np.sqrt(((frames["angle_deg"] - angle) ** 2).mean()) < 0.6
    assert "markers = 5" in (tmp_path / "out" / "film.toml").read_text()
    assert (tmp_path / "out" / "overlay.mp4").exists()


@pytest.mark.parametrize("ends_kPa", [(-60.0, 0.0), (0.0, -60.0)])
def test_suction_gives_no_shapes_to_start_from(ends_kPa: tuple[float, float]) -> None:
    """The only pressure is below that of the air."""
    keys = ("experiment.max_pressure_kPa", "experiment.min_pressure_kPa")
    config = load(None, dict(zip(keys, ends_kPa, strict=True)))
    said = rf"^experiment\.max_pressure_kPa = {ends_kPa[0]:g}: allowed with --silhouette: above 0"
    with pytest.raises(ConfigError, match=said):
        family.simulate(config, lambda *_: None)

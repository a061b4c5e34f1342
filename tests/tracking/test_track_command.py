"""``dolfingrip track`` from a video or pictures to the files that ``diagnose`` reads."""

from __future__ import annotations

import tomllib
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from support.command import run_command
from support.filmed import Filmed, arc, write
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data import measurement
from dolfingrip.extensions.camera import carried

RATE_HZ = 20.0
SHIFT_S = 3.2
WITHIN_90 = 1.645


def bend_deg(pressure_kPa: np.ndarray) -> np.ndarray:
    return 0.5 * pressure_kPa


def pressure_kPa(time_s: np.ndarray) -> np.ndarray:
    return np.interp(time_s, [0.4, 1.6, 1.9, 2.8], [0, 100, 100, 0])


def turn_deg(bend: float) -> float:
    """Turn of the line between the last two of the points, from that of a straight finger."""
    before, last = arc(bend)[-2:]
    return float(np.degrees(np.arctan2(*(last - before))))


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A video of three seconds and its log in bar, whose clock was set earlier."""
    folder, camera = tmp_path_factory.mktemp("film"), Filmed()
    time_s = np.arange(0.0, 3.0, 1 / RATE_HZ)
    bends = bend_deg(pressure_kPa(time_s))
    images = [camera.frame(arc(bend), seed=i) for i, bend in enumerate(bends)]
    write(folder / "film.mp4", images, RATE_HZ)
    log_s = np.arange(-1.0, 4.0, 0.05)
    lines = [
        f"{t + SHIFT_S:.3f};{p / 100:.5f}" for t, p in zip(log_s, pressure_kPa(log_s), strict=True)
    ]
    (folder / "log.csv").write_text("\n".join(["Zeit [s];Druck [bar]", *lines]))
    return folder


def test_a_video_becomes_what_diagnose_reads(
    film: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = (film / "film.mp4", "--log", film / "log.csv")
    assert (
        run_command(
            "track", *files, "--in-front", "10", "--set", "finger.length_mm=62", "-o", tmp_path
        )
        == 0
    )
    said = capsys.readouterr().out.strip().splitlines()
    assert said[-1] == f"dolfingrip diagnose {tmp_path / 'film.csv'}"
    config = Config.model_validate({"finger": {"length_mm": 62}})
    found = measurement.read([tmp_path / "film.csv"], config)
    assert not found.warnings
    table, frames = (pd.read_csv(tmp_path / f"film{end}.csv") for end in ("", "_frames"))
    # a line of two dots is no tip's face: its angle is told, and not compared
    assert "angle_deg" not in table
    bends = bend_deg(pressure_kPa(table["time_s"].to_numpy()))
    off = frames["angle_deg"] - [turn_deg(bend) for bend in bends]
    assert np.sqrt((off**2).mean()) < 0.25
    # the shift by the motion is far better here than what a lag could make of it
    assert np.abs(table["pressure_kPa"] - pressure_kPa(table["time_s"].to_numpy())).max() < 3
    for i, (axis, sign) in enumerate((("x", -1), ("z", 1))):
        true = [sign * arc(bend)[-1, i] for bend in bends]
        spread = np.hypot(frames[f"noise_marker_6_{axis}_mm"], frames[f"common_marker_6_{axis}_mm"])
        inside = np.abs(table[f"marker_6_{axis}_mm"] - true) < 2 * spread
        assert inside.mean() > 0.9
    setup = tomllib.loads((tmp_path / "film.toml").read_text())
    np.testing.assert_allclose(np.array(setup["camera"]["markers"])[:, 1], arc(0.0)[:, 1], atol=0.2)
    assert 0.01 < setup["noise"]["marker_6_x_mm"] < 0.2
    # places of the points that rest where these seemed to rest, by the arc, whose line they follow
    every = np.array([arc(bend) * [-1, 1] for bend in bends])
    at_rest = np.array(setup["camera"]["markers"])
    true_mm = carried(every, every[0], at_rest - every[0])
    for i, axis in enumerate("xz"):
        name = f"marker_6_{axis}_mm"
        stds = setup["noise"][name], setup["noise"]["correlated"][name]
        moved = true_mm[:, -1, i] - at_rest[-1, i]
        spread = np.hypot(np.hypot(*stds), setup["nuisance"]["camera_scale"] * moved)
        assert (np.abs(table[name] - true_mm[:, -1, i]) < 2 * spread).mean() > 0.9
    # the camera's errors are told: the plane of bending alone is known to 0.5° about either axis
    assert 0.5 < setup["nuisance"]["camera_tilt_deg"] < 1.5
    assert 0.001 < setup["nuisance"]["camera_scale"] < 0.01
    assert setup["nuisance"].keys() == {
        "camera_tilt_deg", "camera_scale", "camera_zero_mm", "camera_clock_s",
    }  # fmt: skip
    assert setup["camera"]["distance_mm"] == pytest.approx(Filmed().distance_mm - 10, rel=0.15)
    assert (tmp_path / "overlay.mp4").stat().st_size > 1000
    assert "not determined" in (tmp_path / "summary.md").read_text() or "k1" in "".join(said)


def test_pictures_have_their_states_in_their_names(tmp_path: Path) -> None:
    camera, names = Filmed(sheet=False, front_mm=0.0), []
    for p in (0, 40, 80, 120):
        names.append(tmp_path / f"{p}.jpg")
        cv2.imwrite(str(names[-1]), camera.frame(arc(float(bend_deg(np.array(p))))))
    ends = camera.pixels(np.array([[-20.0, 5.0], [-20.0, 65.0]]))
    scale = " ".join(f"{u:.0f},{v:.0f}" for u, v in ends) + " = 60 mm"
    clamp = ",".join(f"{each:.1f}" for each in camera.pixels(np.zeros((1, 2)))[0])
    told = ("--scale", scale, "--in-front", "0", "--clamp", clamp, "--states", "{pressure_kPa}.jpg")
    out = tmp_path / "out"
    assert run_command("track", *names, *told, "--set", "finger.length_mm=62", "-o", out) == 0
    table, errors = (pd.read_csv(out / f"pictures{end}.csv") for end in ("", "_frames"))
    assert table["pressure_kPa"].tolist() == [0, 40, 80, 120]
    off = np.abs(errors["angle_deg"] - [turn_deg(0.5 * p) for p in (0, 40, 80, 120)])
    assert (
        off < 2.5 * np.hypot(errors["noise_angle_deg"], errors["common_angle_deg"]) + 1e-9
    ).all()
    assert (out / "overlay_120.png").exists()
    setup = tomllib.loads((out / "pictures.toml").read_text())
    assert setup["nuisance"]["camera_tilt_deg"] == 2.0
    assert "camera_clock_s" not in setup["nuisance"]
    ends_mm = np.diff(setup["camera"]["scale_mm"], axis=0)
    assert np.linalg.norm(ends_mm) == pytest.approx(60.0, abs=0.5)


def test_the_sheet_is_written_without_a_video(tmp_path: Path) -> None:
    assert run_command("track", "--sheet", "letter", "-o", tmp_path / "sheet.pdf") == 0
    assert (tmp_path / "sheet.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ((), "nothing tells the pressure of the frames; allowed: --log"),
        (("--log", "log.csv", "--light", "10,10"), "--light: allowed: with --log and --event"),
        (("--scale", "3,4 = 5"), '--scale "3,4 = 5": allowed: as "312,400 900,402 = 100 mm"'),
        (("--points", "3;4"), '--points "3;4": allowed'),
        (("--log", "log.csv", "--dots", "9"), "6 dots of one colour are seen in the first frame, "
         "of 9"),
        (("--log", "log.csv", "--colour", "reddish"), "--colour reddish: allowed: red"),
        (("--log", "log.csv", "--event", "lamp", "--knock"), "--event lamp: not in"),
        (("--log", "log.csv", "--tags", "36h11"), "0 tags of 36h11 are seen in the first frame"),
    ],
)  # fmt: skip
def test_what_is_missing_is_said_in_a_line(
    film: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(film)
    found = CliRunner().invoke(
        app, ["track", "film.mp4", *told, "-o", str(tmp_path), "--no-overlay"]
    )
    assert isinstance(found.exception, ConfigError)
    assert message in str(found.exception)
    assert "\n" not in str(found.exception)


def test_a_video_without_scale_is_refused(tmp_path: Path) -> None:
    camera = Filmed(sheet=False)
    write(tmp_path / "film.mp4", [camera.frame(arc(bend)) for bend in (0.0, 10.0, 20.0)])
    (tmp_path / "log.csv").write_text("time_s,pressure_kPa\n0,0\n1,10\n")
    told = ["track", str(tmp_path / "film.mp4"), "--log", str(tmp_path / "log.csv")]
    found = CliRunner().invoke(app, [*told, "-o", str(tmp_path / "out")])
    assert "no printed sheet is seen, and no scale is told; allowed: a sheet" in str(
        found.exception
    )


def refused(folder: Path, *told: object) -> str:
    """The one line by which a command refuses, run in a folder."""
    found = CliRunner().invoke(app, ["track", *map(str, told), "-o", str(folder), "--no-overlay"])
    assert isinstance(found.exception, ConfigError), found.exception
    assert "\n" not in str(found.exception)
    return str(found.exception)


def pictures(folder: Path, names: list[str], states_kPa: list[int]) -> list[Path]:
    """Pictures of a finger before the sheet, which rests in the first one."""
    files = [folder / name for name in names]
    for file, p in zip(files, states_kPa, strict=True):
        cv2.imwrite(str(file), Filmed().frame(arc(0.5 * p)))
    return files


def test_what_refuses_frames_shows_one_of_them(film: Path, tmp_path: Path) -> None:
    """Also where all frames have been read, as without a scale or a log that explains them."""
    camera = Filmed(sheet=False)
    write(tmp_path / "bare.mp4", [camera.frame(arc(bend)) for bend in (0.0, 10.0, 20.0)])
    (tmp_path / "still.csv").write_text("time_s,pressure_kPa\n0,10\n2,10\n4,10\n")
    video, log = film / "film.mp4", film / "log.csv"
    for number, told in enumerate([
        (tmp_path / "bare.mp4", "--log", log, "--shift", "0"),
        (video, "--log", tmp_path / "still.csv"),
        (video, "--log", log, "--dots", "9"),
    ]):  # fmt: skip
        said = refused(out := tmp_path / f"{number}", *told)
        assert said.endswith(f"; {out / 'seen.png'} shows the first frame")
        drawn = cv2.imread(str(out / "seen.png"))
        points = camera.pixels(arc(0.0)) if number == 0 else Filmed().pixels(arc(0.0))
        u, v = np.round(points[2]).astype(int)
        ring = drawn[v - 8 : v + 9, u - 8 : u + 9].reshape(-1, 3)
        assert (np.abs(ring - np.array([255, 120, 0])).max(axis=1) < 60).any()  # of what was found


def test_each_place_that_is_told_has_a_dot(film: Path, tmp_path: Path) -> None:
    """A click beside a dot would make another one the tip."""
    at = [f"{u:.0f},{v:.0f}" for u, v in Filmed().pixels(arc(0.0))]
    told = (film / "film.mp4", "--log", film / "log.csv", "--points")
    said = refused(tmp_path, *told, " ".join([*at[:5], "500,600"]))
    assert said.startswith("5 dots of one colour are seen in the first frame, of 6")
    assert refused(tmp_path, *told, " ".join([at[0], at[0], at[1], at[2]])).startswith("3 dots of")


def test_black_dots_within_the_frame_of_the_sheet(tmp_path: Path) -> None:
    """Its black squares touch, so that all within them is within one black thing."""
    bends, camera = np.linspace(0, 40, 14), Filmed()
    images = [camera.frame(arc(bend), colour=(60, 60, 60), seed=i) for i, bend in enumerate(bends)]
    write(tmp_path / "film.mp4", images)
    at = " ".join(f"{u:.0f},{v:.0f}" for u, v in camera.pixels(arc(0.0)))
    (tmp_path / "log.csv").write_text("time_s,pressure_kPa\n0,0\n1,80\n")
    told = ("--log", tmp_path / "log.csv", "--shift", "0", "--points", at, "--in-front", "10")
    out = tmp_path / "out"
    assert run_command("track", tmp_path / "film.mp4", *told, "--no-overlay", "-o", out) == 0
    frames = pd.read_csv(out / "film_frames.csv")
    assert np.abs(frames["angle_deg"] - [turn_deg(bend) for bend in bends]).max() < 0.5


@pytest.mark.parametrize(
    ("table", "column", "expected"),
    [
        ("file;Druck [bar]\n100.jpg;1,0\n20.jpg;0,2\n0.jpg;0\n", "pressure_kPa", [0, 20, 100]),
        ("file,Volume (mL),who\n0.jpg,0,A\n20.jpg,,A\n100.jpg,1.5,B\n", "volume_ml", [0, 1.5]),
        ("{pressure_mbar}.jpg", "pressure_kPa", [0, 2, 10]),
        ("{volume_ul}.jpg", "volume_ml", [0, 0.02, 0.1]),
    ],
)
def test_states_are_columns_as_import_takes_them(
    table: str, column: str, expected: list[float], tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """Pictures stand in the order of their numbers, where a shell has sorted them by letters."""
    files = sorted(pictures(tmp_path, ["0.jpg", "20.jpg", "100.jpg"], [0, 20, 100]))
    (tmp_path / "states.csv").write_text(table)
    states = table if table.startswith("{") else tmp_path / "states.csv"
    told = ("--states", states, "--in-front", "10", "--no-overlay", "-o", tmp_path / "out")
    assert run_command("track", *files, *told) == 0
    found = pd.read_csv(tmp_path / "out" / "pictures.csv")
    assert found[column].tolist() == pytest.approx(expected)
    last = capsys.readouterr().out.strip().splitlines()[-1]
    assert last == f"dolfingrip diagnose {tmp_path / 'out' / 'pictures.csv'}"


@pytest.mark.parametrize(
    ("states", "words"),
    [
        ("{p}.jpg", 'its unit is not told; add --column "p=pressure_kPa"'),
        ("{number}.jpg", "allowed: pressure (or volume_ml"),
        ("file,pressure_kPa\n0.jpg,0\n", "not in index"),
        ("file,pressure_kPa\n0.jpg,0\n20.jpg,1\n20.jpg,2\n", "has every picture once"),
        ("file,pressure_kPa\n0.jpg,60\n20.jpg,0\n", "the first picture is at 60.0 kPa"),
        ("file,volume_ml\n0.jpg,0.9\n20.jpg,0\n", "the first picture is at 0.9"),
    ],
)
def test_states_that_are_refused(states: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "states.csv").write_text(states)
    told = states if states.startswith("{") else tmp_path / "states.csv"
    files = [tmp_path / "0.jpg", tmp_path / "20.jpg"]
    for file in files:
        file.write_bytes(b"")
    assert words in refused(tmp_path, *files, "--states", told)


def test_a_log_of_a_pump_in_two_parts(film: Path, tmp_path: Path) -> None:
    head, *lines = (film / "log.csv").read_text().replace("Druck [bar]", "Volumen [mL]").split("\n")
    parts = tmp_path / "a.csv", tmp_path / "b.csv"
    for part, of_it in zip(parts, (lines[:40], lines[40:]), strict=True):
        part.write_text("\n".join([head, *of_it]))
    logs = [f"--log={part}" for part in parts]
    told = ("--in-front", "10", "--no-overlay", "-o", tmp_path / "out")
    assert run_command("track", film / "film.mp4", *logs, *told) == 0
    table = pd.read_csv(tmp_path / "out" / "film.csv")
    true_ml = pressure_kPa(table["time_s"].to_numpy()) / 100
    assert np.abs(table["volume_ml"] - true_ml).max() < 0.03
    assert "the clock goes back" in refused(tmp_path, film / "film.mp4", *logs[::-1])

"""Points that other programs have tracked, in files as these programs write them.

The truth is an arc of constant curvature whose line between the last two points is known.
"""

from __future__ import annotations

import pickle
import tomllib
from collections.abc import Callable
from pathlib import Path

import c3d
import h5py
import numpy as np
import pandas as pd
import pytest
from support.command import run_command
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError

NAMES = ("tip", "base", "mid")
"""Not in the order along the finger."""
ALONG_MM = {"base": 10.0, "mid": 35.0, "tip": 60.0}
RATE_HZ = 25.0
PX_PER_MM = 4.0
TIME_S = np.arange(75) / RATE_HZ
PRESSURE_KPA = np.interp(TIME_S, [0.4, 2.0, 2.4, 2.9], [0, 80, 80, 20])
BEND = np.radians(0.6 * PRESSURE_KPA)
"""Turn of the arc's end at 60 mm."""
LOST = (30, "mid")
"""A frame and the point that is lost in it."""


def place_mm(name: str, clamp: bool = False) -> np.ndarray:
    """Places (frames, 2), to the right and down, of an arc that bends to the right."""
    along = 0.0 if clamp else ALONG_MM[name]
    curvature = BEND / 60
    small = np.where(curvature > 1e-9, curvature, 1e-9)
    return np.column_stack([(1 - np.cos(along * small)) / small, np.sin(along * small) / small])


def line_deg() -> np.ndarray:
    arm = place_mm("tip") - place_mm("mid")
    return np.degrees(np.arctan2(arm[:, 0], arm[:, 1]))


def px(name: str) -> np.ndarray:
    return 200 + PX_PER_MM * place_mm(name)


def is_lost(i: int, name: str) -> bool:
    return (i, name) == LOST


def deeplabcut() -> pd.DataFrame:
    scorer = "DLC_resnet50_fingerMay1shuffle1_50000"
    columns = pd.MultiIndex.from_product(
        [[scorer], NAMES, ["x", "y", "likelihood"]], names=["scorer", "bodyparts", "coords"]
    )
    rows = np.hstack([np.column_stack([px(name), np.full(len(TIME_S), 0.99)]) for name in NAMES])
    table = pd.DataFrame(rows, columns=columns)
    table.loc[LOST[0], [(scorer, LOST[1], c) for c in ("x", "y", "likelihood")]] = [
        5.0,
        7.0,
        0.1,
    ]  # it guesses where it sees nothing
    return table


def write_deeplabcut(folder: Path) -> Path:
    deeplabcut().to_csv(file := folder / "points.csv")
    return file


def write_hdf5(folder: Path) -> Path:
    """As pandas writes it by PyTables 3.11, with format="table"."""
    table = deeplabcut()
    rows = np.empty(len(table), dtype=[("index", "<i8"), ("values_block_0", "<f8", (9,))])
    rows["index"], rows["values_block_0"] = table.index, table.to_numpy()
    names = pickle.dumps([(1, table.columns.to_list())], protocol=0)
    with h5py.File(file := folder / "points.h5", "w") as opened:
        group = opened.create_group("df_with_missing")
        group["table"] = rows
        group.attrs["non_index_axes"] = np.bytes_(names)
    return file


def write_tracker(folder: Path) -> Path:
    lines = ["#multi:", "," + "".join(f"{name},," for name in NAMES), "t," + "x,y," * 3]
    for i, time in enumerate(TIME_S):
        cells = [f"{time:.6E}"]
        for name in NAMES:
            u, v = place_mm(name)[i] / 1e3  # m, y upwards
            cells += ["", ""] if is_lost(i, name) else [f"{u:.9E}", f"{-v:.9E}"]
        lines.append(",".join(cells) + ",")
    (file := folder / "points.txt").write_text("\n".join(lines) + "\n")
    return file


def write_trk(folder: Path) -> Path:
    def value(name: str, text: object, kind: str = "double") -> str:
        return f'<property name="{name}" type="{kind}">{text}</property>'

    def thing(kind: str, inner: str) -> str:
        return f'<object class="org.opensourcephysics.{kind}">{inner}</object>'

    def many(kind: str, frames: str) -> str:
        return f'<property name="framedata" type="array" class="[Lorg.{kind};">{frames}</property>'

    masses = ""
    for name in NAMES:
        frames = "".join(
            value(f"[{i}]", thing("cabrillo.tracker.PointMass$FrameData",
                                  value("x", u) + value("y", v)), "object")
            for i, (u, v) in enumerate(px(name)) if not is_lost(i, name)
        )  # fmt: skip
        mass = value("mass", 1.0) + value("name", name, "string")
        mass += many("PointMass$FrameData", frames)
        masses += value("item", thing("cabrillo.tracker.PointMass", mass), "object")
    axes = value("xorigin", 10.0) + value("xscale", 1e3 * PX_PER_MM) + value("yscale", 4e3)
    axes = value("[0]", thing("media.core.ImageCoordSystem$FrameData", axes), "object")
    axes = thing("media.core.ImageCoordSystem", many("ImageCoordSystem$FrameData", axes))
    step = thing("media.core.StepperClipControl", value("delta_t", 1e3 / RATE_HZ))
    panel = value("clipcontrol", step, "object") + value("coords", axes, "object")
    panel += value("length_unit", "m", "string") + value("tracks", masses, "collection")
    text = f'<?xml version="1.0" encoding="UTF-8"?>{thing("cabrillo.tracker.TrackerPanel", panel)}'
    (file := folder / "points.trk").write_text(text)
    return file


def write_kva(folder: Path) -> Path:
    tracks = ""
    for name in NAMES:
        points = ""
        for i, ((u, v), (x, y)) in enumerate(zip(px(name), place_mm(name), strict=True)):
            if not is_lost(i, name):
                x, y = (f"{number:.4f}" for number in (x / 10, -y / 10))
                points += (
                    f'<TrackPoint UserX="{x.replace(".", ",")}" UserXInvariant="{x}" '
                    f'UserY="{y.replace(".", ",")}" UserYInvariant="{y}" UserTime="0:00:00:00">'
                    f"{u:.2f};{v:.2f};{1000 * i}</TrackPoint>"
                )
        tracks += (
            f'<Track id="{name}0" name="{name}"><TimePosition>0</TimePosition>'
            f'<TrackPointList Count="{len(TIME_S)}" UserUnitLength="cm">{points}</TrackPointList>'
            "</Track>"
        )
    (file := folder / "points.kva").write_text(
        '<?xml version="1.0" encoding="utf-8"?><KinoveaVideoAnalysis><FormatVersion>2.0'
        "</FormatVersion><ImageSize>1280;720</ImageSize><AverageTimeStampsPerFrame>1000"
        f"</AverageTimeStampsPerFrame><CaptureFramerate>{RATE_HZ}</CaptureFramerate>"
        f"<Tracks>{tracks}</Tracks></KinoveaVideoAnalysis>"
    )
    return file


def write_kinovea_text(folder: Path) -> Path:
    lines = ["#Kinovea Trajectory data export", "#T X Y", ""]
    for name in NAMES:
        lines.append(f"# {name}")
        for i, (x, y) in enumerate(place_mm(name)):
            if not is_lost(i, name):
                lines.append(f"{1e3 * TIME_S[i]:g} {x:.3f} {-y:.3f}")
        lines.append("")
    (file := folder / "points.txt").write_text("\r\n".join(lines))
    return file


def in_space_m(name: str) -> np.ndarray:
    """Places (frames, 3) in a plane that is turned in the room."""
    x, y = (place_mm(name) / 1e3).T
    return np.column_stack([0.6 * x + 0.3, 1.2 - y, 0.8 * x - 0.1])


def write_motive(folder: Path) -> Path:
    names = [f"Finger:{name}" for name in NAMES]

    def row(first: str, second: str, body: list[str], marker: list[str]) -> str:
        return ",".join([first, second, *(body * 7), *(text for text in marker for _ in range(3))])

    lines = [
        f"Format Version,1.23,Take Name,a,Export Frame Rate,{RATE_HZ:f},Rotation Type,Quaternion,"
        "Length Units,Meters,Coordinate Space,Global",
        "",
        row("", "Type", ["Rigid Body"], ["Marker"] * 3),
        row("", "Name", ["Clamp"], names),
        row("", "ID", ["A1"], ["1", "2", "3"]),
        ",," + "Rotation," * 4 + "Position," * 3 + ",".join(["Position"] * 9),
        "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z," + ",".join("XYZ" * 3),
    ]
    for i, time in enumerate(TIME_S):
        cells = [f"{i}", f"{time:.6f}", *["0.1"] * 7]
        for name in NAMES:
            places = in_space_m(name)[i]
            cells += [""] * 3 if is_lost(i, name) else [f"{number:.6f}" for number in places]
        lines.append(",".join(cells))
    (file := folder / "points.csv").write_text("\n".join(lines))
    return file


def write_c3d(folder: Path) -> Path:
    writer = c3d.Writer(point_rate=RATE_HZ, point_scale=-1.0, point_units="m   ")
    writer.set_point_labels([name.ljust(8) for name in NAMES])
    for i in range(len(TIME_S)):
        points = np.zeros((3, 5))
        for j, name in enumerate(NAMES):
            points[j, :3] = in_space_m(name)[i]
            points[j, 3] = -1 if is_lost(i, name) else 0.0
        writer.add_frames([(points, np.array([[]]))])
    with (file := folder / "points.c3d").open("wb") as stream:
        writer.write(stream)
    return file


def write_plain(folder: Path) -> Path:
    columns = {"time (s)": TIME_S}
    for name in NAMES:
        for axis, values in zip("xy", (place_mm(name) * [1, -1]).T, strict=True):
            lost = np.array([is_lost(i, name) for i in range(len(TIME_S))])
            columns[f"{name}_{axis} [mm]"] = np.where(lost, np.nan, values)
    pd.DataFrame(columns).to_csv(file := folder / "points.csv", index=False)
    return file


SCALE = ("--scale", "100,100 500,100 = 100 mm")
RATE = ("--frame-rate", f"{RATE_HZ}")
CASES = [
    pytest.param(write_deeplabcut, (*SCALE, *RATE, "--clamp", "200,200"), id="DeepLabCut CSV"),
    pytest.param(write_hdf5, (*SCALE, *RATE, "--clamp", "200,200"), id="DeepLabCut HDF5"),
    pytest.param(write_tracker, ("--unit", "m", "--clamp", "0,0"), id="Tracker data file"),
    pytest.param(write_trk, ("--clamp", "200,200"), id="Tracker TRK"),
    pytest.param(write_kva, ("--clamp", "0,0"), id="Kinovea KVA"),
    pytest.param(write_kinovea_text, ("--unit", "mm", *RATE), id="Kinovea text"),
    pytest.param(write_motive, (), id="Motive CSV"),
    pytest.param(write_c3d, (), id="C3D"),
    pytest.param(write_plain, ("--clamp", "0,0"), id="plain CSV"),
]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("log") / "log.csv"
    pd.DataFrame({"time_s": TIME_S + 5, "pressure_kPa": PRESSURE_KPA}).to_csv(file, index=False)
    return file


@pytest.mark.parametrize(("write", "options"), CASES)
def test_points_of_another_program_become_a_table(
    write: Callable[[Path], Path], options: tuple[str, ...], log: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    file = write(tmp_path)
    out = tmp_path / "out"
    assert run_command("track", file, "--log", log, "--shift", "5", *options, "-o", out) == 0
    said = capsys.readouterr().out
    assert "from the clamp: " in said
    order = next(line for line in said.splitlines() if "from the clamp" in line)
    assert order.replace("Finger:", "").endswith("from the clamp: base, mid, tip")
    frames = pd.read_csv(out / "points_frames.csv")
    lost = np.arange(len(TIME_S)) == LOST[0]
    np.testing.assert_allclose(frames["time_s"], TIME_S, atol=1e-6)
    np.testing.assert_allclose(frames["pressure_kPa"], PRESSURE_KPA, atol=1e-3)
    # places are written to 0.001 mm, 0.01 px or 0.001 cm; 0.05° on 25 mm are 0.02 mm
    np.testing.assert_allclose(frames["angle_deg"][~lost], line_deg()[~lost], atol=0.05)
    assert frames["angle_deg"][lost].isna().all()
    table = pd.read_csv(out / "points.csv")
    tilt_deg = tomllib.loads((out / "points.toml").read_text())["nuisance"]["camera_tilt_deg"]
    assert tilt_deg == pytest.approx(1e-4 if write in (write_motive, write_c3d) else 2.0)
    if "--clamp" in options:
        np.testing.assert_allclose(frames["marker_3_x_mm"], -place_mm("tip")[:, 0], atol=0.02)
        np.testing.assert_allclose(frames["marker_3_z_mm"], place_mm("tip")[:, 1], atol=0.02)
        assert "marker_2_x_mm" in table
        assert frames["marker_2_x_mm"][lost].isna().all()
    else:
        assert "angle_deg" in table


def test_the_clamp_and_the_points_may_be_names(log: Path, tmp_path: Path) -> None:
    file = write_plain(tmp_path)
    table = pd.read_csv(file)
    table["clamp_x [mm]"], table["clamp_y [mm]"] = 0.0, 0.0
    table["screw_x [mm]"], table["screw_y [mm]"] = 300.0, 80.0
    table.to_csv(file, index=False)
    options = ("--points", "base,mid,tip", "--clamp", "clamp")
    out = tmp_path / "out"
    assert run_command("track", file, "--log", log, "--shift", "5", *options, "-o", out) == 0
    frames = pd.read_csv(out / "points_frames.csv")
    np.testing.assert_allclose(frames["marker_3_x_mm"], -place_mm("tip")[:, 0], atol=0.02)
    assert "marker_4_x_mm" not in frames


def test_a_long_table_keeps_both_sides_of_a_step(tmp_path: Path) -> None:
    """A step of 30 ms at 100 Hz, in a record of which most frames are left out."""
    time_s = np.arange(3000) / 100
    kpa = np.interp(time_s, [11.11, 11.14, 21.11, 21.12], [0, 40, 40, 0])
    points = {"time (s)": time_s, "base_x [mm]": 0.0, "base_y [mm]": 0.0, "mid_y [mm]": -50.0}
    points |= {"mid_x [mm]": kpa / 40, "tip_x [mm]": kpa / 10, "tip_y [mm]": -100.0}
    pd.DataFrame(points).to_csv(file := tmp_path / "points.csv", index=False)
    log = tmp_path / "log.csv"
    pd.DataFrame({"time_s": time_s, "pressure_kPa": kpa}).to_csv(log, index=False)
    assert run_command("track", file, "--log", log, "--shift", "0", "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "points.csv")
    assert len(table) < 400
    between = np.interp(time_s, table["time_s"], table["pressure_kPa"])
    np.testing.assert_allclose(between, kpa, atol=1e-3)


def _empty(file: Path) -> None:
    file.write_text("")


def _pickle(file: Path) -> None:
    """A list of names that would call a function when it is unpickled."""
    with h5py.File(file, "w") as opened:
        group = opened.create_group("df")
        group["table"] = np.zeros(3, dtype=[("values_block_0", "<f8", (2,))])
        group.attrs["non_index_axes"] = np.bytes_(b"cos\nsystem\n(S'echo here'\ntR.")


@pytest.mark.parametrize(
    ("name", "make", "options", "words"),
    [
        ("a.kva", _empty, (), "points cannot be read"),
        ("a.c3d", _empty, (), "points cannot be read"),
        ("a.trk", lambda file: file.write_text("<object/>"), (), "points cannot be read"),
        ("a.h5", _pickle, (), "os.system in a list of names"),
        ("points.csv", lambda file: write_plain(file.parent), ("--points", "tip,base,top"),
         "top: no point of"),
        ("points.csv", lambda file: write_plain(file.parent), ("--points", "tip"),
         "at least 2 points"),
        ("points.csv", lambda file: write_plain(file.parent), ("--light", "3,4"), "no pictures"),
        ("points.csv", lambda file: write_deeplabcut(file.parent), (), "--frame-rate Hz"),
        ("points.csv", lambda file: write_deeplabcut(file.parent), RATE, "no scale is told"),
        ("points.txt", lambda file: write_tracker(file.parent), (), "its unit is not told"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_in_one_line(
    name: str, make: Callable[[Path], object], options: tuple[str, ...], words: str, log: Path,
    tmp_path: Path,
) -> None:  # fmt: skip
    file = tmp_path / name
    make(file)
    if "--light" in options:
        options = (*options, "--event", "lamp")
    command = ["track", str(file), "--log", str(log), *options, "-o", str(tmp_path / "out")]
    error = CliRunner().invoke(app, command).exception
    assert isinstance(error, ConfigError)
    assert words in str(error)
    assert "\n" not in str(error)
    assert "allowed: " in str(error)

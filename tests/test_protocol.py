"""Protocol files: what becomes of segments, poses and measured time stamps, and what is refused."""

from __future__ import annotations

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from dolfingrip import config
from dolfingrip.cli import app as cli
from dolfingrip.cli.experiment_commands import _poses
from dolfingrip.config import ConfigError
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.protocol import pressure_stops
from dolfingrip.sections import protocol_file as protocol

COUPON = ("coupon", "displacement_mm")
"""An experiment and its control."""

LAB = """
cycles = 2
[[segment]]
to_mm = 3.3
rate_mm_per_s = 1.1
readings = 2
[[segment]]
hold_s = 9.0
readings = 3
[[segment]]
to_mm = 0.0
readings = 1
[[pose]]
name = "warm"
set = ["material.mu_MPa=2.0"]
[[pose]]
name = "cold"
"""


def _written(tmp_path: Path, text: str, name: str = "lab.toml") -> Path:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    return file


def test_segments_become_readings(tmp_path: Path) -> None:
    table, poses = protocol.read(_written(tmp_path, LAB), *COUPON)
    down = 3.3 / 2.5
    one = [1.5, 3.0, 4.0, 6.0, 12.0, 12.0 + down]
    expected = [0.0, *one, *(time + 12.0 + down for time in one)]
    np.testing.assert_allclose(table["time_s"], expected)
    np.testing.assert_allclose(
        table["displacement_mm"], [0.0, *2 * [1.65, 3.3, 3.3, 3.3, 3.3, 0.0]]
    )
    assert table["cycle"] == 7 * [1] + 6 * [2]
    assert table["branch"] == [
        "loading", *2 * [*2 * ["loading"], *3 * ["hold"], "unloading"]
    ]  # fmt: skip
    assert [pose.name for pose in poses] == ["warm", "cold"]
    config.Config().changed(protocol=table)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[[segment]]\nto_kPa = 5.0\n", "segment: allowed: to_mm or hold_s in a coupon"),
        ("[[segment]]\nto_mm = 5.0\nhold_s = 1.0\n", "allowed: exactly one of to_kPa, to_mm"),
        ("[[segment]]\nto_mm = 5.0\nrate_mm_per_s = -1\n", "segment.rate_mm_per_s = -1: allowed:"),
        ("[[segment]]\nto_cm = 5.0\n", "segment.to_cm: unknown key; did you mean segment.to_mm?"),
        ("cycles = 2\n", "allowed: at least one [[segment]]"),
        ("[[segment]]\nhold_s = 1.0\n[[pose]]\nset = []\n", "pose.name: missing"),
        ("segment", "not TOML"),
    ],
)
def test_bad_files_are_one_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        protocol.read(_written(tmp_path, text), *COUPON)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_time_stamps_of_a_measurement(tmp_path: Path) -> None:
    rows = (
        "experiment,specimen,cycle,branch,time_s,pressure_kPa,angle_deg\n"
        "blocked_force,A,1,loading,0,0,0\n"
        "bending,A,1,loading,5,0,0\nbending,A,1,loading,6,20,3\nbending,A,2,hold,9,20,4\n"
        "bending,B,1,loading,0,50,9\n"
    )
    file = _written(tmp_path, rows, "a.csv")
    table, poses = protocol.read(file, "bending", "pressure_kPa", "A")
    assert table == {
        "time_s": [0.0, 1.0, 4.0],
        "pressure_kPa": [0.0, 20.0, 20.0],
        "cycle": [1, 1, 2],
        "branch": ["loading", "loading", "hold"],
    }
    assert not poses
    assert protocol.read(file, "bending", specimen="B")[0]["pressure_kPa"] == [50.0]
    # the only one there is need not be named
    assert protocol.read(file, "blocked_force")[0]["pressure_kPa"] == [0.0]
    assert protocol.read(file, "blocked_force", specimen="A")[0]["pressure_kPa"] == [0.0]
    with pytest.raises(ConfigError) as refused:
        protocol.read(file, *COUPON)
    assert str(refused.value) == f"--protocol {file}: missing column displacement_mm"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bend"], "--protocol {}: 2 specimens of bending; allowed: one, by --specimen: A, B"),
        (["bend", "--specimen", "C"], "--specimen C: not in {}; allowed: A, B"),
        (["force", "--specimen", "B"], "--specimen B: not in {}; allowed: A"),
        (["coupon"], "--protocol {}: missing column displacement_mm"),
    ],
)
def test_a_specimen_of_several_is_to_be_named(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    rows = (
        "experiment,specimen,time_s,pressure_kPa\n"
        "bending,A,0,0\nbending,A,1,20\nbending,B,0,0\nblocked_force,A,0,0\n"
    )
    file = _written(tmp_path, rows, "measured.csv")
    assert _refused([*arguments, "--protocol", str(file)], tmp_path, monkeypatch) == 2
    assert capfd.readouterr() == ("", f"dolfingrip: {said.format(file)}\n")


def test_a_specimen_without_a_measurement_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert _refused(["bend", "--specimen", "A"], tmp_path, monkeypatch) == 2
    said = "dolfingrip: --specimen A: allowed: with --protocol FILE.csv\n"
    assert capfd.readouterr() == ("", said)
    lab = str(_written(tmp_path, LAB))
    assert _refused(["coupon", "--specimen", "A", "--protocol", lab], tmp_path, monkeypatch) == 2
    said = f"dolfingrip: --specimen A: {lab} is no CSV; allowed: with a .csv\n"
    assert capfd.readouterr() == ("", said)


def _refused(arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit code of a command that must not have written anything."""
    out = tmp_path / "results"
    monkeypatch.setattr("sys.argv", ["dolfingrip", *arguments, "--out", str(out)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert not out.exists()
    return int(ended.value.code or 0)


def test_command_runs_each_pose_and_each_result_is_a_data_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = ["coupon", "--protocol", str(_written(tmp_path, LAB)), "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", ["dolfingrip", *arguments])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert not ended.value.code
    assert "Uniaxial tension" in capfd.readouterr().out
    force = {}
    for pose in ("warm", "cold"):
        with (tmp_path / pose / "result.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 13
        force[pose] = float(rows[2]["force_N"])
        again, _ = protocol.read(tmp_path / pose / "result.csv", *COUPON)
        assert again["branch"][:4] == ["loading", "loading", "loading", "hold"]
        text = (tmp_path / pose / "result.toml").read_text(encoding="utf-8")
        assert 'experiment = "coupon"\ngauge_length_mm = 33.0\narea_mm2 = 9.0\n' in text
        assert (tmp_path / pose / "curve.png").exists()
    assert force["warm"] == pytest.approx(2.0 / 2.93 * force["cold"], rel=1e-6)


def test_supplies_of_single_cavities(tmp_path: Path) -> None:
    """Ramps arrive together, the farthest at the rate; a CSV says the same in columns."""
    text = (
        "[[segment]]\nto_kPa = 20.0\nreadings = 1\n"
        "[[segment]]\nto_kPa = 10.0\ncavity_kPa = { cavity_2 = -50.0 }\nreadings = 2\n"
        "[[segment]]\ncavity_kPa = { cavity_2 = 0.0 }\nreadings = 1\n"
    )
    table, _ = protocol.read(_written(tmp_path, text), "bending")
    assert table["pressure_kPa"] == [0.0, 20.0, 15.0, 10.0, 10.0]
    assert table["cavity_2_supply_kPa"] == [0.0, 0.0, -25.0, -50.0, 0.0]
    np.testing.assert_allclose(table["time_s"], [0.0, 0.8, 1.8, 2.8, 4.8])
    assert table["branch"] == ["loading", "loading", "unloading", "unloading", "unloading"]
    keys = {protocol.key(name): values for name, values in table.items()}
    found = config.load(None, {**keys, "mesh.file": "none.msh", "finger.kind": "adopted"})
    assert found.cavity.own == {"cavity_2": (0.0, 0.0, -25.0, -50.0, 0.0)}
    assert found.pressures_kPa == (-50.0, 20.0)
    assert found.walls_may_meet(["cavity_2"])
    assert not found.walls_may_meet(["cavity"])
    rows = [",".join(map(str, ("bending", "A", *row))) for row in zip(*table.values(), strict=True)]
    head = ",".join(("experiment", "specimen", *table))
    measured, _ = protocol.read(_written(tmp_path, "\n".join([head, *rows]), "a.csv"), "bending")
    assert measured == table


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"pressure_kPa": [0.0]}, "1 values: allowed: one for each time of the protocol, 2"),
        ({"pressure_kPa": [0.0, -150.0]}, "-150 kPa in it, below absolute vacuum"),
        ({"pressure_kPa": [0.0, 1.0], "closed": True}, "allowed: not beside closed = true"),
        ({"pressure_kPa": [0.0, 1.0], "pressure_ratio": 0.5}, "not beside a pressure_ratio"),
    ],
)
def test_what_a_supply_of_its_own_cannot_be(table: dict[str, object], said: str) -> None:
    given = {"time_s": [0.0, 1.0], "pressure_kPa": [0.0, 1.0]}
    with pytest.raises(ConfigError, match=f"cavity.cavity.pressure_kPa = .*{said}"):
        config.from_dict({"protocol": given, "cavity": {"cavity": table}})


def test_readings_of_a_wait_are_never_at_one_time() -> None:
    """However many there are: the first of a long wait is a millionth of it after its start."""
    for count in (1, 2, 14, 80, 1000):
        times = 10.0 + np.array([0.0, *protocol.waits(0.2, count)])
        assert (np.diff(times) > 0).all(), count
        assert times[-1] == 10.2
    np.testing.assert_allclose(protocol.waits(9.0, 3), [1.0, 3.0, 9.0])  # 3ⁿ, as before
    np.testing.assert_allclose(np.diff(protocol.waits(0.2, 80, even=True)), 0.0025)


WAIT = "[[segment]]\nto_kPa = 10.0\nreadings = 1\n[[segment]]\nhold_s = 0.2\nreadings = 4\n"


@pytest.mark.parametrize("by", ["option", "file"])
def test_waits_in_motion_are_evenly_spaced(tmp_path: Path, by: str) -> None:
    """No part of a swing counts for more, whether the option or the file asks for it."""
    file = _written(tmp_path, "[experiment]\ndynamic = true\n", "own.toml")
    asked = SimpleNamespace(
        protocol=_written(tmp_path, WAIT), specimen=None, out=tmp_path,
        config=file if by == "file" else None,
    )  # fmt: skip
    changes = {"experiment.dynamic": True} if by == "option" else {}
    ((_, found),) = _poses(EXPERIMENTS["bending"], asked, changes)  # type: ignore[arg-type]
    assert found.experiment.dynamic
    np.testing.assert_allclose(found.protocol.time_s, [0, 0.4, 0.45, 0.5, 0.55, 0.6])
    ((_, still),) = _poses(EXPERIMENTS["bending"], replaced(asked), {})  # type: ignore[arg-type]
    np.testing.assert_allclose(np.diff(still.protocol.time_s[2:]) * 27 / 0.2, [2, 6, 18])


def test_a_wait_is_read_at_equal_times(tmp_path: Path) -> None:
    """Every 0.05 s, in statics, too; the wait need not be a multiple of it."""
    wait = "[[segment]]\nhold_s = 0.22\nevery_s = 0.05\n"
    found, _ = protocol.read(_written(tmp_path, wait), "bending")
    np.testing.assert_allclose(found["time_s"], [0, 0.05, 0.1, 0.15, 0.2])
    for line, said in (
        ("every_s = 0.3", "every_s = 0.3: allowed: 2.2e-06 to 0.22 s, the length of the wait"),
        ("every_s = 0.1\nreadings = 3", "every_s = 0.1: allowed: beside hold_s, without readings"),
    ):
        with pytest.raises(ConfigError, match=said):
            protocol.read(_written(tmp_path, f"[[segment]]\nhold_s = 0.22\n{line}\n"), "bending")


def replaced(asked: SimpleNamespace) -> SimpleNamespace:
    """The same without a configuration of its own, so that nothing moves."""
    return SimpleNamespace(**{**vars(asked), "config": None})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"protocol.time_s": [0.0, 1.0, 1.0], "protocol.pressure_kPa": [0.0, 5.0, 5.0]},
         "protocol.time_s = 1, 1: allowed: with experiment.dynamic each 1e-09 s or more after"),
        ({"experiment.hold_s": 1e-20, "experiment.max_pressure_kPa": 10.0}, "experiment.hold_s: "),
    ],
)  # fmt: skip
def test_one_time_twice_is_refused_in_motion(change: dict[str, object], said: str) -> None:
    """Two states at one time have no velocity between them."""
    with pytest.raises(ConfigError, match=said):
        pressure_stops(config.load(None, {**change, "experiment.dynamic": True}))
    assert len(pressure_stops(config.load(None, change))) >= 3

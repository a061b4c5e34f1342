"""Two logs of one test, whose clocks and rates differ, become one table."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from support.command import run_command

SHIFT_S = 7.3


def pressure_kPa(time_s: np.ndarray) -> np.ndarray:
    return np.interp(time_s, [1, 4, 5, 8, 10, 12], [0, 60, 60, 10, 50, 0])


@pytest.fixture
def logs(tmp_path: Path) -> tuple[Path, Path]:
    """Angles at 30 Hz, and pressures in bar at 8 Hz, from a clock that shows 7.3 s more."""
    time_s, log_s = np.arange(0, 13, 1 / 30), np.arange(-2, 15, 1 / 8)
    angles, pressures = tmp_path / "angles.csv", tmp_path / "pressures.csv"
    p_kPa = pressure_kPa(time_s)
    turned = 0.5 * p_kPa + 0.004 * p_kPa**2
    pd.DataFrame({"time [s]": time_s, "angle [deg]": turned}).to_csv(angles, index=False)
    columns = {"t_board": log_s + SHIFT_S, "p [bar]": pressure_kPa(log_s) / 100}
    pd.DataFrame(columns).to_csv(pressures, index=False)
    return angles, pressures


BOARD = ("--column", "t_board=time_s")


@pytest.mark.parametrize("turned", [False, True])
def test_the_shift_is_found_by_the_motion(
    turned: bool, logs: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = logs[::-1] if turned else logs
    assert run_command("import", *files, *BOARD, "-o", tmp_path / "out") == 0
    said = " ".join(capsys.readouterr().out.split())
    shift, std = map(float, re.search(r"is at ([\d.]+) ± ([\d.]+) s", said).groups())  # type: ignore[union-attr]
    assert abs(shift - SHIFT_S) < 1 / 16  # half a row of the slower log
    assert std > 0.3  # it contains the finger's own lag
    table = pd.read_csv(tmp_path / "out" / f"{files[0].stem}.csv")
    assert len(table) == 390
    off = table["pressure_kPa"] - pressure_kPa(table["time_s"].to_numpy())
    assert np.abs(off).max() < 2.5  # 25 kPa/s by half a row, and corners between rows
    assert "± 0." in (tmp_path / "out" / f"{files[0].stem}.toml").read_text()


def test_a_shift_that_is_told_is_taken(logs: tuple[Path, Path], tmp_path: Path) -> None:
    options = (*BOARD, "--shift", "10.3", "-o", tmp_path / "out")
    assert run_command("import", *logs, *options) == 0
    table = pd.read_csv(tmp_path / "out" / "angles.csv")
    off = table["pressure_kPa"] - pressure_kPa(table["time_s"].to_numpy() + 3)
    assert np.abs(off).max() < 2
    assert table["time_s"].max() < 11.9  # later rows are beyond the pressures


@pytest.mark.parametrize(
    ("angles", "options", "words"),
    [
        ("time [s],angle [deg]\n" + "".join(f"{i / 9},{i * 37 % 11}\n" for i in range(90)), (),
         "of the motion at best"),
        ("time [s],angle [deg]\n0,0\n1,5\n2,7\n", (), "or --shift SECONDS"),
        ("time [s],angle [deg]\n0,0\n1,5\n2,7\n", ("--shift", "99"), "allowed: at least 2"),
        ("time [s],angle [deg]\n0,0\n2,5\n1,7\n", ("--shift", "9"), "line 4: the clock goes back"),
        ("time [s],p2 [kPa]\n0,0\n1,5\n2,7\n", (), "a pressure or travel in one"),
        ("frame,angle [deg]\n0,0\n1,5\n2,7\n", (), "a time in each"),
    ],
)  # fmt: skip
def test_logs_without_a_common_clock_are_refused(
    angles: str, options: tuple[str, ...], words: str, logs: tuple[Path, Path], tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    logs[0].write_text(angles)
    assert run_command("import", *logs, *BOARD, *options, "-o", tmp_path / "out") == 2
    said = capsys.readouterr().err.strip()
    assert words in said
    assert "\n" not in said

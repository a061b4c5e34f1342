"""Tables with several fingers side by side become rows of several specimens."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from support.command import run_command

BLOCKS = """Finger 1,,,Finger 2,,
Time (s),Pressure (kPa),Angle (deg),Time (s),Pressure (kPa),Angle (deg)
0,0,0,0,0,0
1,10,5,1,11,6
2,20,11,2,21,12
3,30,17,,,
"""
SHARED = """Time (s),Pressure (kPa),Finger 1 angle (deg),Finger 2 angle (deg),Finger 3 angle (deg)
0,0,0,0,0
1,10,5,6,7
2,20,11,12,
"""


def imported(text: str, tmp_path: Path, *options: str) -> pd.DataFrame:
    (tmp_path / "wide.csv").write_text(text)
    out = tmp_path / "out"
    assert run_command("import", tmp_path / "wide.csv", *options, "-o", out) == 0
    return pd.read_csv(out / "wide.csv", dtype={"specimen": str})


def test_blocks_are_specimens(tmp_path: Path) -> None:
    table = imported(BLOCKS, tmp_path, "--side-by-side")
    assert table["specimen"].tolist() == ["1"] * 4 + ["2"] * 3
    assert table["pressure_kPa"].tolist() == [0, 10, 20, 30, 0, 11, 21]
    assert table["angle_deg"].tolist() == [0, 5, 11, 17, 0, 6, 12]


def test_a_column_of_all_is_shared(tmp_path: Path) -> None:
    table = imported(SHARED, tmp_path, "--side-by-side")
    assert table["specimen"].tolist() == ["1"] * 3 + ["2"] * 3 + ["3"] * 2
    assert table["pressure_kPa"].tolist() == [0, 10, 20, 0, 10, 20, 0, 10]
    assert table["angle_deg"].tolist() == [0, 5, 11, 0, 6, 12, 0, 7]
    assert "specimen 3 is Finger 3 angle (deg)" in (tmp_path / "out" / "wide.toml").read_text()


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        (BLOCKS, (), "or --side-by-side"),
        (SHARED.replace("Time (s)", "p (kPa)"), ("--side-by-side",), "3 of angle"),
        ("t (s),p (kPa),angle (deg)\n0,0,0\n1,5,4\n", ("--side-by-side",), "1 of angle_deg"),
    ],
)  # fmt: skip
def test_what_is_not_certain_is_refused(
    text: str, options: tuple[str, ...], words: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "wide.csv").write_text(text)
    assert run_command("import", tmp_path / "wide.csv", *options, "-o", tmp_path / "out") == 2
    said = capsys.readouterr().err.strip()
    assert words in said
    assert "\n" not in said

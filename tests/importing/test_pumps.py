"""A pump's counter: the volume that it has put into the cavity, for a liquid."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from support.command import run_command

COUNTED = [0, 0.1, 0.2, 0.3, 0.4, 0, 0.1, 0.2, 0.3]


def imported(folder: Path, *more: str, **columns: list[float]) -> int:
    table = {"time [s]": range(9), "Volume infused [mL]": COUNTED, "angle [deg]": range(9)}
    pd.DataFrame(table | columns).to_csv(folder / "pump.csv", index=False)
    return run_command("import", folder / "pump.csv", "--out", folder / "out", *more)


@pytest.mark.parametrize(
    ("option", "expected"),
    [
        ("--withdraws", [0, 0.1, 0.2, 0.3, 0.4, 0.4, 0.3, 0.2, 0.1]),
        ("--no-withdraws", COUNTED),
    ],
)
def test_a_counter_that_begins_at_0_again(
    option: str, expected: list[float], tmp_path: Path
) -> None:
    assert imported(tmp_path, option) == 0
    table = pd.read_csv(tmp_path / "out" / "pump.csv")
    assert table["volume_ml"].to_list() == pytest.approx(expected)


def test_what_a_counter_means_is_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert imported(tmp_path) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "line 7: the volume begins at 0 again" in said
    assert "--withdraws or --no-withdraws" in said


def test_a_pressure_beside_a_volume_is_asked_about(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert imported(tmp_path, **{"p [kPa]": [*range(9)]}) == 2
    assert "p [kPa]=ignore" in " ".join(capsys.readouterr().err.split())

"""A pump's counter: the volume that it has put into the cavity, for a liquid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
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


def test_what_was_infused_and_what_was_withdrawn(tmp_path: Path) -> None:
    withdrawn = [0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4]
    columns = {"Volume infused [mL]": [0, 0.1, 0.2, 0.3, *[0.4] * 5], "Withdrawn [mL]": withdrawn}
    assert imported(tmp_path, **columns) == 0
    table = pd.read_csv(tmp_path / "out" / "pump.csv")
    expected = [0, 0.1, 0.2, 0.3, 0.4, 0.3, 0.2, 0.1, 0]
    assert table["volume_ml"].to_list() == pytest.approx(expected)


def test_a_counter_with_noise_and_a_missing_cell(tmp_path: Path) -> None:
    """Three strokes there and back; the last row of one may be above a usual step, or have none."""
    draw = np.random.default_rng(0)
    true = np.tile(np.r_[np.arange(0, 40), np.arange(40, 0, -1)] / 20, 3)
    counted = np.where(np.arange(len(true)) % 80 < 40, true, 2 - true)
    counted = counted.round(2) + draw.normal(0, 0.004, len(true))
    counted[10] = np.nan
    columns = {"time [s]": range(240), "infused [mL]": counted, "angle [deg]": 20 * true}
    pd.DataFrame(columns).to_csv(tmp_path / "pump.csv", index=False)
    told = (tmp_path / "pump.csv", "--withdraws", "--out", tmp_path / "out")
    assert run_command("import", *told) == 0
    table = pd.read_csv(tmp_path / "out" / "pump.csv")
    assert len(table) == 239
    off_ml = table["volume_ml"] - np.delete(true, 10)
    assert off_ml.abs().max() < 0.15  # a step at each turn


def test_a_pump_without_times_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "pump.csv").write_text("Volume [mL],angle [deg]\n0,0\n1,5\n2,9\n")
    assert run_command("import", tmp_path / "pump.csv", "--out", tmp_path / "out") == 0
    assert "no time: diagnose assumes how fast the pump is" in capsys.readouterr().out

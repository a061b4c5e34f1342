"""What boards write to a serial line, and rows of spreadsheets that are merged."""

from __future__ import annotations

from pathlib import Path

import openpyxl
import pandas as pd
import pytest
from support.command import run_command

ROWS = [(0, 0.0, 0.0), (25, 1.21, 3.1), (50, 2.4, 6.0), (75, 3.6, 8.2)]
NAMES = ("--column", "P=pressure_kPa", "--column", "A=angle_deg")


@pytest.mark.parametrize(
    "text",
    [
        "\n".join(f"T(ms) = {t}\nP = {p}\nA = {a}" for t, p, a in ROWS),
        "\n".join(f"P = {p}, T(ms) = {t}, A = {a}" for t, p, a in ROWS),
        "\n".join(f"T(ms): {t}\r\nP: {p}\r\nA: {a}" for t, p, a in ROWS),
    ],
)
def test_names_and_numbers_of_a_board(text: str, tmp_path: Path) -> None:
    (tmp_path / "board.txt").write_text(text)
    assert run_command("import", tmp_path / "board.txt", *NAMES, "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "board.csv")
    assert table["time_s"].tolist() == [0, 0.025, 0.05, 0.075]
    assert table["pressure_kPa"].tolist() == [p for _, p, _ in ROWS]
    assert table["angle_deg"].tolist() == [a for _, _, a in ROWS]


@pytest.mark.parametrize(("head", "name"), [("", "value"), ("p\n", "p"), ("P = ", "P")])
def test_one_number_a_line_is_a_log(head: str, name: str, tmp_path: Path) -> None:
    prefix = head if "=" in head else ""
    lines = [f"{prefix}{p}" for p in range(0, 60, 4)]
    (tmp_path / "board.txt").write_text(("" if prefix else head) + "\n".join(lines))
    angles = pd.DataFrame({"frame": range(15), "angle [deg]": [0.5 * p for p in range(0, 60, 4)]})
    angles.to_csv(tmp_path / "angles.csv", index=False)
    command = ["import", tmp_path / "angles.csv", tmp_path / "board.txt", "-o", tmp_path / "out"]
    options = ["--column", f"{name}=pressure_kPa", "--frame-rate", "10", "--shift", "0"]
    assert run_command(*command, *options) == 0
    table = pd.read_csv(tmp_path / "out" / "angles.csv")
    assert table["pressure_kPa"].tolist() == list(range(0, 60, 4))
    assert run_command(*command, *options[:2]) == 2  # nothing tells its time


STAMPED = [f"12:00:59.{t:03d} -> " for t, _, _ in ROWS]


@pytest.mark.parametrize(
    ("lines", "names"),
    [
        ([f"{s}P = {p}, A = {a}" for s, (_, p, a) in zip(STAMPED, ROWS, strict=True)], NAMES),
        ([f"{s}P = {p}\n{s}A = {a}" for s, (_, p, a) in zip(STAMPED, ROWS, strict=True)], NAMES),
        (
            [f"[{s[:12]}] P: {p} A: {a}" for s, (_, p, a) in zip(STAMPED, ROWS, strict=True)],
            NAMES,
        ),
        (
            [f"{s}{p},{a}" for s, (_, p, a) in zip(STAMPED, ROWS, strict=True)],
            ("--column", "column 2=pressure_kPa", "--column", "column 3=angle_deg"),
        ),
    ],
)
def test_the_time_of_a_serial_monitor(
    lines: list[str], names: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "board.txt").write_text("\n".join(lines))
    assert run_command("import", tmp_path / "board.txt", *names, "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "board.csv")
    assert table["time_s"].tolist() == pytest.approx([0, 0.025, 0.05, 0.075])
    assert table["angle_deg"].tolist() == [a for _, _, a in ROWS]


def test_messages_and_lines_that_are_cut_off_are_no_readings(tmp_path: Path) -> None:
    """A board that was started writes bytes of another rate and messages between its readings."""
    lines = [f"T(ms) = {t}\nP = {p}\nA = {a}" for t, p, a in ROWS]
    text = "\n".join(["\0\xff", "Ready", lines[0], "Valve open", *lines[1:], "T(m"])
    (tmp_path / "board.txt").write_text(text, encoding="latin-1")
    assert run_command("import", tmp_path / "board.txt", *NAMES, "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "board.csv")
    assert table["time_s"].tolist() == [0, 0.025, 0.05, 0.075]
    assert table["pressure_kPa"].tolist() == [p for _, p, _ in ROWS]


def test_a_number_that_is_two_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "board.txt").write_text("1.21\n2.4\n8.479.68\n6.0\n7.2")
    assert run_command("import", tmp_path / "board.txt", "-o", tmp_path / "out") == 2
    assert "points and commas without a rule, as 8.479.68;" in capsys.readouterr().err


def test_rows_that_are_merged_with_the_one_above_are_one_row(tmp_path: Path) -> None:
    """Of the second pair the pressure alone is merged: these are two readings at one pressure."""
    book = openpyxl.Workbook()
    sheet = book.active
    for row in [("p [kPa]", "angle [deg]"), (0, 0), (None, None), (10, 4.0), (None, 4.2), (20, 9)]:
        sheet.append(row)
    for area in ("A2:A3", "B2:B3", "A4:A5"):
        sheet.merge_cells(area)
    book.save(tmp_path / "merged.xlsx")
    assert run_command("import", tmp_path / "merged.xlsx", "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "merged.csv")
    assert table["pressure_kPa"].tolist() == [0, 10, 10, 20]
    assert table["angle_deg"].tolist() == [0, 4, 4.2, 9]

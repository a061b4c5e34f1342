"""``dolfingrip import``: its output, its questions at a terminal, and who offers it."""

from __future__ import annotations

import os
import pty
import re
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.cli.import_command import import_table
from dolfingrip.cli.settings import ImportSettings
from dolfingrip.config import ConfigError

CAMERA = "Frame,Pressure (psi),Angle\n1,0.0,0.0\n2,2.9,6.1\n3,5.8,11.0\n"


def test_a_terminal_is_asked_and_others_get_the_line_to_add(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "camera.csv"
    file.write_text(CAMERA)
    found = CliRunner().invoke(app, ["import", str(file), "-o", str(tmp_path / "out")])
    assert isinstance(found.exception, ConfigError)
    assert '--column "Angle=angle_deg" or --column "Angle=angle_rad"' in str(found.exception)
    assert "Pressure (psi)" in found.output
    assert "× 6.89476" in found.output
    assert not (tmp_path / "out").exists()

    own, other = pty.openpty()
    os.write(own, b"9\n1\n1\n30\n")  # none of them, degrees; a frame rate; its value
    with os.fdopen(other) as keys, open(os.ttyname(other), "w", encoding="utf-8") as terminal:
        monkeypatch.setattr(sys, "stdin", keys)
        monkeypatch.setattr(sys, "stdout", terminal)
        import_table(ImportSettings(table=file, out=tmp_path / "out"))
        monkeypatch.undo()
    os.close(own)
    lines = (tmp_path / "out" / "camera.csv").read_text().splitlines()
    assert lines[0] == "time_s,pressure_kPa,angle_deg"
    assert lines[2].split(",")[2] == "6.1"
    assert float(lines[2].split(",")[0]) == pytest.approx(1 / 30)


@pytest.mark.parametrize("command", [["diagnose"], ["coupon", "--fit"]])
def test_commands_that_read_measurements_offer_it(command: list[str], tmp_path: Path) -> None:
    file = tmp_path / "camera.csv"
    file.write_text(CAMERA)
    found = CliRunner().invoke(app, [*command, str(file), "-o", str(tmp_path / "out")])
    assert isinstance(found.exception, ConfigError)
    said = str(found.exception)
    assert "Pressure (psi) is pressure_kPa" in said
    assert f"what dolfingrip import {file} --out FOLDER writes" in said
    assert '--column "Angle=angle_rad"' in said


def test_a_table_in_the_format_in_another_encoding_is_told_so(tmp_path: Path) -> None:
    """Its names are right, so the line says what is not."""
    file = tmp_path / "a.csv"
    rows = ["stretch\tstress_MPa", *(f"{1 + i / 10}\t{i / 20}" for i in range(5))]
    file.write_text("\n".join(rows), encoding="utf-16")
    found = CliRunner().invoke(app, ["coupon", "--fit", str(file), "-o", str(tmp_path / "out")])
    assert isinstance(found.exception, ConfigError)
    assert "(its columns are named so, but are no UTF-8 with commas)" in str(found.exception)


@pytest.mark.parametrize(
    ("header", "sign"), [("pressure_kPa", "-"), ("Vacuum [kPa]", "-"), ("Vacuum [kPa]", "")]
)
def test_suction_is_a_pressure_below_that_of_the_air(
    header: str, sign: str, tmp_path: Path
) -> None:
    """A column of a vacuum is turned; a ratio of the set-up would count, too."""
    file = tmp_path / "suction.csv"
    file.write_text(f"{header},angle_deg\n0,0\n{sign}20,4.1\n{sign}40,8.3\n")
    file.with_suffix(".toml").write_text('experiment = "bending"\nrate_kPa_per_s = 5.0\n')
    written = CliRunner().invoke(app, ["import", str(file), "-o", str(tmp_path / "in")])
    assert written.exit_code == 0, written.output
    setup = tomllib.loads((tmp_path / "in" / "suction.toml").read_text(encoding="utf-8"))
    ratio = setup.get("cavity", {}).get("cavity", {}).get("pressure_ratio", 1.0)
    rows = (tmp_path / "in" / "suction.csv").read_text().splitlines()[1:]
    assert [ratio * float(row.split(",")[0]) for row in rows] == [0, -20, -40]


def test_the_page_s_table_is_imported_as_the_page_says(tmp_path: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "lab_table.md").read_text("utf-8")
    table = re.search(r"<<'END'\n(.*?)END\n", page, re.S)
    assert table is not None
    file = tmp_path / "finger.csv"
    file.write_text(table[1], encoding="utf-8")
    found = CliRunner().invoke(app, ["import", str(file), "-o", str(tmp_path / "out")])
    shown = re.search(r"```text\n(.*?)```", page, re.S)
    assert shown is not None
    *printed, refused = [" ".join(line.split()) for line in shown[1].splitlines()]
    assert [" ".join(line.split()) for line in found.output.splitlines()] == printed
    assert str(found.exception).partition(": ")[2] == refused.partition("csv: ")[2]
    (more,) = re.findall(r"-o out/lab/imported (--.*)", page)
    asked = ["import", str(file), "-o", str(tmp_path / "out"), *more.split()]
    assert CliRunner().invoke(app, asked).exit_code == 0
    rows = (tmp_path / "out" / "finger.csv").read_text().splitlines()
    assert rows[:3] == ["time_s,pressure_kPa,angle_deg", "0,0,0", "1,12.5,5.3"]

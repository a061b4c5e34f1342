"""What was measured stays what it is; tables of the format, of single supplies and of no text."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from support.example import EXAMPLES
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.cli.import_command import named
from dolfingrip.config import ConfigError
from dolfingrip.importing import importing
from dolfingrip.importing.importing import ImportedTable, understand
from dolfingrip.importing.told import Question, Told

LENGTH, AREA = 40.0, 12.0
"""With which the machine below works out strain (mm) and stress (mm²)."""


def machine(folder: Path, *left_out: str) -> Path:
    """A table of a machine that writes what it measures, and what it works out of it."""
    travel = np.linspace(0.0, 60.0, 13)
    load = 0.4 * AREA * (1 + travel / LENGTH - (1 + travel / LENGTH) ** -2)
    columns = {
        "Traverse [cm]": travel / 10 + 0.5,  # its zero is elsewhere
        "Load [N]": load,
        "Strain [%]": 100 * travel / LENGTH,
        "Stress [kPa]": 1e3 * load / AREA,
    }
    file = folder / "machine.csv"
    table = pd.DataFrame({name: each for name, each in columns.items() if name not in left_out})
    table.to_csv(file, index=False, float_format="%.6f")
    return file


def notes(found: ImportedTable) -> str:
    return " ".join(found.notes)


@pytest.mark.parametrize(("length", "area"), [(50.0, 12.0), (40.0, 10.0), (40.0, 12.0)])
def test_what_the_machine_measured_is_written_whatever_it_worked_out(
    length: float, area: float, tmp_path: Path
) -> None:
    told = Told(gauge_length=length, area=area, zero_at_rest=True)
    found = understand(machine(tmp_path), told)
    assert not found.questions
    assert found.table["displacement_mm"].iloc[-1] == pytest.approx(60.0)
    assert found.table["force_N"].iloc[-1] == pytest.approx(0.4 * AREA * (2.5 - 0.16))
    assert {"strain", "stress_MPa"}.isdisjoint(found.table)
    rows = {header: name for header, name, _ in found.mapping()}
    assert rows["Strain [%]"] == "passed over (strain)"
    doubted = "by both the gauge length is 40 mm, and 50 mm is told" in notes(found)
    assert doubted == (length != LENGTH)
    doubted = "by both the area is 12 mm², and 10 mm² is told" in notes(found)
    assert doubted == (area != AREA)
    assert ("disagree" in notes(found)) == ((length, area) != (LENGTH, AREA))


def test_what_is_worked_out_is_said_in_the_mapping(tmp_path: Path) -> None:
    """Travel is the strain by the length that is told, where no travel was measured."""
    file = machine(tmp_path, "Traverse [cm]", "Stress [kPa]")
    found = understand(file, Told(gauge_length=50.0, area=10.0))
    rows = {header: (name, done) for header, name, done in found.mapping()}
    assert rows["Strain [%]"] == ("displacement_mm", "% × 0.5")
    assert found.table["displacement_mm"].iloc[-1] == pytest.approx(75.0)
    assert found.table["force_N"].iloc[-1] == pytest.approx(0.4 * AREA * (2.5 - 0.16))


def test_a_stretch_becomes_a_travel_as_its_mapping_says(tmp_path: Path) -> None:
    file = tmp_path / "stretch.csv"
    file.write_text("stretch,stress_MPa\n1.0,0\n1.5,0.2\n2.0,0.3\n")
    found = understand(file, Told(gauge_length=20.0, area=5.0))
    assert found.table["displacement_mm"].tolist() == [0, 10, 20]
    assert found.mapping()[0] == ("stretch", "displacement_mm", "× 20 -20")


@pytest.mark.parametrize("file", sorted((EXAMPLES / "coupons").glob("*.csv")), ids=lambda f: f.stem)
def test_a_table_of_the_format_is_taken_as_it_is(file: Path, tmp_path: Path) -> None:
    ran = CliRunner().invoke(app, ["import", str(file), "-o", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert "in the format already" in " ".join(ran.output.split())
    pd.testing.assert_frame_equal(
        pd.read_csv(tmp_path / file.name), pd.read_csv(file, comment="#"), check_dtype=False
    )


NAMES = ("strain", "stretch", "stress_MPa", "transverse_strain", "pressure_kPa", "mode", "p [bar]",
         "", "Kraft [N]", "Weg [mm]", "cavity_2_supply_kPa", "marker_1_x_mm", "tip_x_mm", "frame",
         "suction_kPa", "setpoint", "true strain")  # fmt: skip


def test_a_changed_table_of_coupons_is_taken_or_refused_in_a_line(tmp_path: Path) -> None:
    seed = random.randrange(2**32)
    print(f"seed {seed}")
    draw = random.Random(seed)
    said: list[str] = []
    lines = (EXAMPLES / "coupons" / "ninjaflex_uniaxial.csv").read_text().splitlines()[:12]
    for _ in range(60):
        table = [line.split(",") for line in lines]
        for _ in range(draw.randint(1, 3)):
            column, row = draw.randrange(len(table[0])), draw.randrange(1, len(table))
            change = draw.randrange(4)
            if change == 0:
                table[0][column] = draw.choice(NAMES)
            elif change == 1 and len(table[0]) > 2:
                table = [each[:column] + each[column + 1 :] for each in table]
            elif change == 2:
                table[row][column] = draw.choice(["", "x", "-1", "1e9", "bending"])
            else:
                name = draw.choice(["", "bending", "blocked_force", "grasp", "1"])
                table = [table[0], *([*e[:column], name, *e[column + 1 :]] for e in table[1:])]
        file = tmp_path / "changed.csv"
        file.write_text("\n".join(map(",".join, table)) + "\n")
        try:
            found = understand(file, draw.choice([Told(), Told(gauge_length=33.0, area=9.0)]))
            if not found.questions:
                importing.write(found, tmp_path / "out")
        except (ConfigError, Question) as error:
            said.append(str(error))
    assert said
    assert not [each for each in said if "\n" in each]


ARM = (
    "A [Pa],B [Pa],C [Pa],kappa [1/mm],mark,theta [rad]\n0,0,0,0,1.5,0\n5000,0,9000,0.002,1.2,0.1\n"
)


def test_supplies_markers_and_curvatures_are_named_by_column(tmp_path: Path) -> None:
    file = tmp_path / "arm.csv"
    file.write_text(ARM)
    column = ("A [Pa]=cavity_1_supply_kPa", "B [Pa]=cavity_2_supply_kPa",
              "C [Pa]=cavity_3_supply_Pa", "kappa [1/mm]=curvature_2_per_m",
              "mark=marker_2_x_cm")  # fmt: skip
    found = understand(file, Told(column=named(column)))
    assert not found.questions
    last = found.table.iloc[-1]
    assert last["cavity_1_supply_kPa"] == pytest.approx(5)
    assert last["cavity_2_supply_kPa"] == 0
    assert last["cavity_3_supply_kPa"] == pytest.approx(9)
    assert last["curvature_2_per_m"] == pytest.approx(2)
    assert last["marker_2_x_mm"] == pytest.approx(12)
    assert last["pressure_kPa"] == pytest.approx(9)
    assert "no column is pressure_kPa" in notes(found)
    csv, _ = importing.write(found, tmp_path / "out")
    assert "cavity_3_supply_kPa" in csv.read_text()


def test_a_table_of_three_supplies_is_told_how_to_name_them(tmp_path: Path) -> None:
    file = tmp_path / "arm.csv"
    file.write_text("p1 [kPa],p2 [kPa],theta [deg]\n0,0,0\n5,9,3\n")
    (question,) = understand(file, Told()).questions
    assert '--column "p1 [kPa]=cavity_1_supply_kPa"' in map(str, question.options)
    with pytest.raises(ConfigError, match="cavity_2_supply_kPa, marker_1_x_mm"):
        understand(file, Told(column=named(["p1 [kPa]=cavity_2_suply_kPa"])))


@pytest.mark.parametrize(
    ("beginning", "said"),
    [
        (b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "not readable as a MAT or HDF5 file"),
        (b"\x89HDF\r\n\x1a\n", "not readable as a MAT or HDF5 file"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a workbook of Excel 97 to 2003"),
        (b"\x02P\x05\x00\x00\x00\x01\x00", "`dolfingrip track` takes them, and a table"),
    ],
)
def test_files_that_are_no_text_are_named(beginning: bytes, said: str, tmp_path: Path) -> None:
    file = tmp_path / "table"
    file.write_bytes(beginning + bytes(600))
    with pytest.raises(ConfigError) as error:
        understand(file, Told())
    assert said in str(error.value)
    assert "CSV" in str(error.value)
    assert "\n" not in str(error.value)

"""A laboratory's table as cells: numbers, clocks, dates, decimal signs and headers by their values.

The references are what a person reads in the cell.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import ConfigError
from dolfingrip.importing import cells
from dolfingrip.importing.cells import AmbiguousDate, Cells
from dolfingrip.importing.told import Question, Told


@pytest.mark.parametrize(
    ("cell", "decimal", "value"),
    [
        ("12.5", ".", 12.5),
        (" 12,5 ", ",", 12.5),
        ("1,234.5", ".", 1234.5),
        ("1.234,5", ",", 1234.5),
        ("1 234,5", ",", 1234.5),
        ("1'234.5", ".", 1234.5),
        ("1\u202f234", ".", 1234.0),
        ("−3.5e−2", ".", -0.035),
        ("+7.", ".", 7.0),
    ],
)
def test_a_number_is_read_by_its_decimal_sign(cell: str, decimal: str, value: float) -> None:
    assert cells.number(cell, decimal) == value


@pytest.mark.parametrize("cell", ["", "-", "n/a", "NaN", "#N/A", "#DIV/0!", "OL", "overflow", "—"])
def test_a_cell_without_a_value_is_no_number(cell: str) -> None:
    assert cells.missing(cell)
    assert math.isnan(cells.number(cell, "."))


@pytest.mark.parametrize("cell", ["12 kPa", "a", "1-2", "1:30"])
def test_what_is_no_number_is_refused(cell: str) -> None:
    with pytest.raises(ValueError, match=cell):
        cells.number(cell, ".")


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["0:00:01", "0:01:00,5", "1:00:00"], [1.0, 60.5, 3600.0]),
        (["11:59 am", "12:00 pm", "1:30 pm"], [43140.0, 43200.0, 48600.0]),
        (["12:30 am", "", "1:00 AM"], [1800.0, math.nan, 3600.0]),
        # over midnight
        (["23:59:59", "0:00:01"], [86399.0, 86401.0]),
        (["2024-03-01 10:00:00", "2024-03-02 10:00:01"], [36000.0, 122401.0]),
        # a leap year's February has 29 days
        (["28.02.2024 00:00:00", "01.03.2024 00:00:00"], [0.0, 172800.0]),
        # the second month cannot be a 13
        (["12/03/2024 00:00:00", "13/03/2024 00:00:00"], [0.0, 86400.0]),
        (["1:02.5", "1:03.0"], [62.5, 63.0]),
    ],
)
def test_clocks_are_seconds(texts: list[str], expected: list[float]) -> None:
    np.testing.assert_array_equal(cells.seconds(texts), expected)


@pytest.mark.parametrize(
    "texts",
    [
        ["12.5", "0:00:01"],
        ["0:00:01", "soon"],
        ["2024-03-01 10:00:00", "10:00:01"],
        ["10:00:00Z", "10:00:01+01:00"],
    ],
)
def test_a_column_of_other_things_is_no_clock(texts: list[str]) -> None:
    assert cells.seconds(texts) is None


def test_a_date_with_two_orders_is_asked_for() -> None:
    texts = ["01/02/2024 00:00:00", "03/02/2024 00:00:00"]
    with pytest.raises(AmbiguousDate, match="01/02/2024"):
        cells.seconds(texts)
    day = 86400.0
    assert cells.seconds(texts, "dmy") == [0.0, 2 * day]
    assert cells.seconds(texts, "mdy") == [0.0, 60 * day]  # 2 January to 2 March in a leap year


def test_pairs_are_hours_or_minutes() -> None:
    assert cells.pairs(["1:30", "2:15"]) == [1.5, 2.25]
    assert cells.pairs(["1:30", "2:75"]) is None
    assert cells.pairs(["1.5"]) is None


def _read(folder: Path, text: str, told: Told | None = None, encoding: str = "utf-8") -> Cells:
    file = folder / "table.csv"
    file.write_bytes(text.encode(encoding))
    return cells.read(file, told or Told())


TABLES = {
    "commas": "p [kPa],angle [deg]\n0,0.5\n10.5,4.25\n",
    "semicolons and decimal commas": "p [kPa];angle [deg]\n0;0,5\n10,5;4,25\n",
    "tabs": "p [kPa]\tangle [deg]\n0\t0.5\n10.5\t4.25\n",
    "bars and rules": "p [kPa] | angle [deg]\n---|---\n0 | 0.5\n10.5 | 4.25\n",
    "spaces": "p[kPa] angle[deg]\n0 0.5\n10.5 4.25\n",
    "a row of units": "p,angle\nkPa,deg\n0,0.5\n10.5,4.25\n",
    "a separator that is told": "sep=;\np [kPa];angle [deg]\n0;0.5\n10.5;4.25\n",
    "units in cells": "p,angle\n0 kPa,0.5 deg\n10.5 kPa,4.25 deg\n",
    "an instrument's header": (
        "rate,100,5\ngain,2,1\nEnd of header\np [kPa],angle [deg]\n0,0.5\n10.5,4.25\n"
    ),
    "means below": "p [kPa],angle [deg]\n0,0.5\n10.5,4.25\nmean,2.4\n",
    "errors behind numbers": "p [kPa],angle [deg]\n0,0.5 ± 0.1\n10.5,4.25 +/- 0.1\n",
}


@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_the_same_in_each_form(name: str, tmp_path: Path) -> None:
    found = _read(tmp_path, TABLES[name])
    header = [entry.replace(" ", "") for entry in found.header]
    assert header == ["p[kPa]", "angle[deg]"]
    numbers = [
        [cells.number(cell, found.decimal) for cell in found.column(place)] for place in (0, 1)
    ]
    assert numbers == [[0.0, 10.5], [0.5, 4.25]]


def test_cells_in_another_unit_are_those_of_the_first(tmp_path: Path) -> None:
    found = _read(tmp_path, "p,angle\n20 kPa,1 deg\n0.3 bar,2 deg\n")
    assert found.header == ["p [kPa]", "angle [deg]"]
    assert [float(cell) for cell in found.column(0)] == pytest.approx([20.0, 30.0], rel=1e-12)


def test_a_log_with_names_in_each_line_is_a_table(tmp_path: Path) -> None:
    found = _read(tmp_path, "P: 0 kPa, A: 0.5 deg\nP: 10.5 kPa, A: 4.25 deg\n")
    assert found.header == ["P [kPa]", "A [deg]"]
    assert [float(cell) for cell in found.column(1)] == [0.5, 4.25]


def test_a_line_that_has_its_names_twice_is_two_rows(tmp_path: Path) -> None:
    found = _read(tmp_path, "P: 0, A: 0.5, P: 1, A: 2.5\nP: 10.5, A: 4.25, P: 11, A: 5\n")
    assert found.column(0) == ["0", "1", "10.5", "11"]


@pytest.mark.parametrize("encoding", ["cp1252", "utf-16", "utf-8-sig"])
def test_letters_of_an_encoding_are_read(encoding: str, tmp_path: Path) -> None:
    text = "Druck [kPa];Krümmung über alles [°]\n0;0,5\n10,5;4,25\n"
    found = _read(tmp_path, text, encoding=encoding)
    assert found.header == ["Druck [kPa]", "Krümmung über alles [°]"]


def test_a_number_that_may_be_a_thousand_is_asked_for(tmp_path: Path) -> None:
    text = "p [kPa];angle [deg]\n1,234;2,345\n2,345;3,456\n"
    with pytest.raises(Question, match="1,234: a decimal sign, or thousands"):
        _read(tmp_path, text)
    assert _read(tmp_path, text, Told(decimal=",")).decimal == ","
    # a number of four digits without a group tells
    assert _read(tmp_path, text + "1000;4,567\n").decimal == ","


def test_a_row_of_another_length_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"line 3: 4 entries; allowed: as many as above, 2"):
        _read(tmp_path, "p,angle\n0,1\n1,2,3,4\n2,3\n3,4\n")


def test_a_file_without_a_table_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no table in it; allowed: a header and rows"):
        _read(tmp_path, "no numbers here\n")

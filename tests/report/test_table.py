"""The console's table: units in the headings, rows of both results matched by pressure."""

from __future__ import annotations

import io
from typing import Any

import pytest
from rich.console import Console
from rich.table import Table

from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.blocked_force import BlockedForce
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.report.table import tabulate

COLUMNS = 80
"""Characters in a line of a terminal that nobody has widened."""


def _printed(table: Table) -> list[str]:
    console = Console(width=COLUMNS, record=True, file=io.StringIO())
    console.print(table)
    return console.export_text().splitlines()


def _text(*results: Any) -> tuple[str, list[list[str]]]:
    """What stands above the line, words only, and the cells of the rows below it."""
    shown = (Bending.table, BlockedForce.table)
    lines = _printed(tabulate(*zip(shown, results, strict=False)))
    line = next(i for i, line in enumerate(lines) if set(line) == {"─"})
    return " ".join(" ".join(lines[:line]).split()), [row.split() for row in lines[line + 1 :]]


def test_both_results_side_by_side() -> None:
    bending = {"pressure_kPa": [0, 50, 100], "angle_deg": [-0.0, 18.26, 38.1]}
    blocked = {"pressure_kPa": [0, 100], "force_N": [0, 0.97]}
    headings, rows = _text(bending, blocked)
    assert headings == "Blocked Pressure Angle force (kPa) (°) (N)"  # line by line
    assert rows == [["0", "0.0", "0.000"], ["50", "18.3", "–"], ["100", "38.1", "0.970"]]


def test_unloading_has_its_own_rows() -> None:
    result = {
        "pressure_kPa": [0, 50, 0],
        "branch": ["loading", "loading", "unloading"],
        "angle_deg": [0, 20, 1.5],
    }
    headings, rows = _text(result)
    assert "Branch" in headings
    assert [row[1] for row in rows] == ["loading", "loading", "unloading"]


def test_each_cycle_has_its_own_rows() -> None:
    """Equal pressures of one branch, in the order in which they come."""
    result = {"pressure_kPa": [0, 50, 0, 50, 0], "angle_deg": [0, 20, 1.5, 20.5, 1.6]}
    assert _text(result)[1] == [
        ["0", "0.0"], ["50", "20.0"], ["0", "1.5"], ["50", "20.5"], ["0", "1.6"],
    ]  # fmt: skip


@pytest.mark.parametrize("experiment", EXPERIMENTS.values(), ids=lambda each: each.command)
def test_every_table_is_whole_in_80_columns(experiment: Experiment) -> None:
    """All words of the headings and all numbers, of results as large as any."""
    largest = {"°": -179.96, "kPa": 234.375, "N": 12.3456}
    result: dict[str, Any] = {"branch": ["loading", "hold"]}
    words = {"loading", "hold", "Branch"}
    for column in experiment.table:
        value = largest.get(column.heading.rpartition("(")[2].strip(")"), 98.7654)
        result[column.name] = [value, -1e-9]
        words |= {format(value, column.form), *column.heading.split()}
    lines = _printed(tabulate((experiment.table, result), title=experiment.title))
    assert max(map(len, lines)) <= COLUMNS
    assert words <= set(" ".join(lines).split())
    assert "…" not in "".join(lines)


def test_the_error_of_the_mesh_stands_beside_the_reading() -> None:
    result = {"pressure_kPa": [0, 250], "angle_deg": [0.0, 147.57], "tip_x_mm": [0.0, -67.6]}
    shown = tabulate((Bending.table, result), errors={"angle_deg": [0.0, -0.43]})
    lines = _printed(shown)
    assert "147.6 (mesh: -0.4)" in lines[-1]
    assert "mesh" not in lines[-2]


@pytest.mark.parametrize("value", [-0.0, -1e-9, 0.0])
def test_zero_has_no_sign(value: float) -> None:
    _, rows = _text({"pressure_kPa": [value], "angle_deg": [value]})
    assert rows == [["0", "0.0"]]


def test_nothing_to_tabulate() -> None:
    with pytest.raises(ValueError, match="no column to tabulate"):
        tabulate()

"""The console's table: units in the headings, rows of both results matched by pressure."""

from __future__ import annotations

import io
from typing import Any

import pytest
from rich.console import Console

from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.blocked_force import BlockedForce
from dolfingrip.report.table import tabulate


def _text(*results: Any) -> str:
    console = Console(width=120, record=True, file=io.StringIO())
    shown = (Bending.table, BlockedForce.table)
    console.print(tabulate(*zip(shown, results, strict=False)))
    return console.export_text()


def test_both_results_side_by_side() -> None:
    bending = {"pressure_kPa": [0, 50, 100], "angle_deg": [-0.0, 18.26, 38.1]}
    blocked = {"pressure_kPa": [0, 100], "force_N": [0, 0.97]}
    text = _text(bending, blocked)
    for heading in ("Pressure (kPa)", "Angle (°)", "Blocked force (N)"):
        assert heading in text
    assert "Branch" not in text
    rows = [
        [cell.strip() for cell in line.strip("│").split("│")]
        for line in text.splitlines()
        if line.startswith("│")
    ]
    assert rows == [["0", "0.0", "0.000"], ["50", "18.3", "–"], ["100", "38.1", "0.970"]]


def test_unloading_has_its_own_rows() -> None:
    result = {
        "pressure_kPa": [0, 50, 0],
        "branch": ["loading", "loading", "unloading"],
        "angle_deg": [0, 20, 1.5],
    }
    text = _text(result)
    assert "unloading" in text
    assert text.count("│ loading") == 2


def test_nothing_to_tabulate() -> None:
    with pytest.raises(ValueError, match="no column to tabulate"):
        tabulate()

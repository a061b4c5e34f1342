"""Output whose reader has gone, or that was closed from the start: no file is lost."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dolfingrip.cli.console import console, resumable
from dolfingrip.jobs.interrupts import Interrupted
from dolfingrip.report.table import of_rows

COMMAND = [sys.executable, "-P", "-m", "dolfingrip"]
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "HWLOC_HIDE_ERRORS": "2"}
MESH_FILES = ["finger.inp", "finger.msh", "finger.vtk"]
COARSE = ["--set", "mesh.size_mm=8", "--set", "mesh.edge_size_mm=8"]


def _without_a_reader(arguments: list[str]) -> tuple[int, str]:
    """Exit code and errors of the command, with its output pipe closed."""
    reading, writing = os.pipe()
    os.close(reading)
    try:
        ended = subprocess.run(
            [*COMMAND, *arguments], env=ENVIRONMENT, stdout=writing, stderr=subprocess.PIPE,
            text=True, timeout=120, check=False,
        )  # fmt: skip
    finally:
        os.close(writing)
    return ended.returncode, ended.stderr


def test_a_reader_that_goes_away_loses_no_file(tmp_path: Path) -> None:
    """As in ``dolfingrip mesh | head``: PETSc, once loaded, would abort at the first word."""
    assert _without_a_reader(["mesh", "-o", str(tmp_path), *COARSE]) == (0, "")
    assert sorted(file.name for file in tmp_path.iterdir()) == MESH_FILES


@pytest.mark.parametrize("arguments", [["--help"], ["config"], ["extensions"]])
def test_text_without_a_reader_ends_quietly(arguments: list[str]) -> None:
    assert _without_a_reader(arguments) == (0, "")


def test_bad_input_keeps_its_exit_code_without_a_reader() -> None:
    code, errors = _without_a_reader(["config", "--set", "finger.wall_mm=-1"])
    assert code == 2
    assert (
        errors
        == "dolfingrip: --set finger.wall_mm = -1: allowed: at least 0.001 and at most 10000 mm\n"
    )


def test_an_output_that_is_closed_from_the_start_loses_no_file(tmp_path: Path) -> None:
    words = " ".join([*COMMAND, "mesh", "-o", str(tmp_path), *COARSE])
    ended = subprocess.run(
        ["sh", "-c", f"{words} >&-"], env=ENVIRONMENT, stderr=subprocess.PIPE,
        text=True, timeout=120, check=False,
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (0, "")
    assert sorted(file.name for file in tmp_path.iterdir()) == MESH_FILES


def test_lines_are_whole_where_there_is_no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sentence and a row of a table are each one line of a file."""
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    screen = console()
    sentence, cell = ("far " * 60).strip(), ("wide " * 40).strip()
    screen.print(sentence)
    screen.print(of_rows(("A", "B"), [(cell, cell)]))
    lines = sys.stdout.getvalue().splitlines()  # type: ignore[attr-defined]
    assert lines[0] == sentence
    assert any(line.count(cell) == 2 for line in lines)
    assert max(map(len, lines)) < 2 * len(cell) + 20  # nothing is filled up to a width


@pytest.mark.parametrize("kept", [True, False])
def test_an_interrupt_names_no_folder_that_is_not_there(kept: bool, tmp_path: Path) -> None:
    folder = tmp_path / "simulations"
    if kept:
        folder.mkdir()
        (folder / "one").touch()
    with pytest.raises(Interrupted) as told, resumable(console(), folder):
        raise KeyboardInterrupt
    assert (str(folder) in str(told.value)) == kept

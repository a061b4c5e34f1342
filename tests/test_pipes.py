"""Output whose reader has gone, or that was closed from the start: no file is lost."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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

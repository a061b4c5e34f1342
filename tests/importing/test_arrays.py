"""MAT files of MATLAB, as MATLAB 5 and 7.3 write them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io
from support.command import run_command

TIME_S = np.linspace(0, 2, 9)
DATA = {
    "time_s": TIME_S[:, None],
    "pressure_kPa": 30 * TIME_S[None],  # a row
    "angle_deg": 12 * TIME_S[:, None],
    "gain": np.array([[2.5]]),
}


def write_5(file: Path, data: Mapping[str, Any]) -> None:
    scipy.io.savemat(file, {**data, "operator": "A. B."})


def write_73(file: Path, data: Mapping[str, Any]) -> None:
    """HDF5 behind 512 bytes of text; arrays are turned, texts are numbers of their letters."""

    def fill(group: h5py.Group, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            if isinstance(value, Mapping):
                fill(group.create_group(name), value)
                group[name].attrs["MATLAB_class"] = np.bytes_("struct")
            else:
                group[name] = np.asarray(value).T
                group[name].attrs["MATLAB_class"] = np.bytes_("double")

    with h5py.File(file, "w", userblock_size=512) as opened:
        fill(opened, data)
        opened["operator"] = np.array([[65, 66, 67, 68, 69, 70, 71, 72, 73]], dtype="u2")
        opened["operator"].attrs["MATLAB_class"] = np.bytes_("char")
        opened.create_group("#refs#")["a"] = TIME_S
    with file.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")


WRITERS = pytest.mark.parametrize("write", [write_5, write_73])


@WRITERS
def test_arrays_of_one_length_are_a_table(write: Callable[..., None], tmp_path: Path) -> None:
    write(tmp_path / "test.mat", DATA)
    assert run_command("import", tmp_path / "test.mat", "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "test.csv")
    assert [*table] == ["time_s", "pressure_kPa", "angle_deg"]
    np.testing.assert_allclose(table["angle_deg"], 12 * TIME_S)


@WRITERS
def test_the_names_of_arrays_are_asked(
    write: Callable[..., None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = {"angle_deg": np.arange(4.0)[:, None], "pressure_kPa": np.arange(4.0)[:, None]}
    matrix = np.column_stack([TIME_S, 30 * TIME_S, 12 * TIME_S])
    write(file := tmp_path / "test.mat", {"run": DATA, "rest": other, "all": matrix})
    assert run_command("import", file, "-o", tmp_path / "out") == 2
    said = capsys.readouterr().err
    names = ["angle_deg", "pressure_kPa", "time_s"] if write is write_73 else [*DATA][:3]
    assert f'--sheet "run: {", ".join(names)}"' in said  # HDF5 has them in alphabetical order
    assert '--sheet "rest: angle_deg, pressure_kPa"' in said
    sheet = ("--sheet", "all: all column 1, all column 2, all column 3")
    columns = [
        f"--column=all column {i}={name}"
        for i, name in enumerate(("time_s", "pressure_bar", "angle_deg"), 1)
    ]
    assert run_command("import", file, *sheet, *columns, "-o", tmp_path / "out") == 0
    table = pd.read_csv(tmp_path / "out" / "test.csv")
    np.testing.assert_allclose(table["pressure_kPa"], 3000 * TIME_S)


@pytest.mark.parametrize(
    "content", [b"", b"MATLAB 5.0 MAT-file" + bytes(200), b"\x89HDF\r\n\x1a\n"]
)
def test_broken_files_are_refused(
    content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (file := tmp_path / "test.mat").write_bytes(content)
    assert run_command("import", file, "-o", tmp_path / "out") == 2
    assert str(file) in capsys.readouterr().err


def test_a_file_without_columns_says_what_it_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_5(file := tmp_path / "test.mat", {"p": np.arange(4.0), "angle": np.arange(5.0)})
    assert run_command("import", file, "-o", tmp_path / "out") == 2
    assert "p, angle; allowed: two arrays of one length" in capsys.readouterr().err


def test_structures_in_a_row_and_readings_in_a_row(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An array of structures is a table for each; of a matrix the longer side has the readings."""
    dtype = [(name, object) for name in ("time_s", "pressure_kPa", "angle_deg")]
    runs = [(TIME_S, 30 * TIME_S, slope * TIME_S) for slope in (12, 15)]
    content = {"run": np.array(runs, dtype), "wide": np.array(runs[0])}
    scipy.io.savemat(file := tmp_path / "test.mat", content)
    command = ("import", file, "-o", tmp_path / "out")
    assert run_command(*command) == 2
    assert '"wide: wide column 1, wide column 2, wide column 3"' in capsys.readouterr().err
    assert run_command(*command, "--sheet", "run 2: time_s, pressure_kPa, angle_deg") == 0
    table = pd.read_csv(tmp_path / "out" / "test.csv")
    np.testing.assert_allclose(table["angle_deg"], 15 * TIME_S)

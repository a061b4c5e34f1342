"""What a person can type wrongly, and what the machine can refuse: one line, never a traceback."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.command import run_command

from dolfingrip.cli import reference_commands
from dolfingrip.cli.command import Subcommand

COMMAND = (sys.executable, "-P", "-m", "dolfingrip")
LONG = 300 * "n"
DIGITS = 401 * "1"


def _refused(capfd: pytest.CaptureFixture[str], *arguments: str, code: int = 2) -> str:
    """The line by which a command refuses its arguments; nothing else is written."""
    assert run_command(*arguments) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("dolfingrip: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    return err


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "said"),
    {
        "no section": (("config", "--set", ".gripper.R_mm=nan"), "--set .gripper.R_mm=nan: allow"),
        "no option": (("bend", "--zzz"), "No such option: --zzz; allowed: see dolfingrip"),
        "no command": (("bnd",), "No such command 'bnd'"),
        "no number": (("train", "x", "--epochs", "many"), "'--epochs'"),
        "too few": (("train", "x", "--epochs", "0"), "--epochs 0: allowed: at least 1"),
        "no choice": (("doe", "--points", "all"), "--points all: allowed: grid, sobol, lhs"),
        "missing": (("morph", "x.msh", "--xi", "0", "0"), "Missing option '--out'"),
        "digits": (("config", "--set", f"mesh.size_mm={DIGITS}"), "size_mm: a number of 401 dig"),
        "more digits": (("config", "--set", f"finger.wall_mm={5000 * '1'}"), "finger.wall_mm = "),
        "deep": (("config", "--set", f"mesh.size_mm={20_000 * '['}"), "mesh.size_mm = "),
        "control": (("config", "--set", "fin\x1bger.wall_mm=1"), r"fin\x1bger"),
        "long name": (("mesh", "--out", LONG), "a name of 300 bytes; allowed: at most 255"),
        "long file": (("config", "--config", LONG), "a name of 300 bytes; allowed: at most 255"),
        "no UTF-8": (("mesh", "--out", os.fsdecode(b"bad\xff")), r"--out bad\udcff: not in UTF-8"),
        "grid": (
            ("doe", "--parameter", "morph.xi1=0:1:99999999"),
            "99999999: allowed: 2 to 100000",
        ),
        "grids": (
            ("doe", "--parameter", "morph.xi1=0:1:999", "--parameter", "morph.xi2=0:1:999"),
            "a grid of 999 x 999 designs; allowed: 100000 in all",
        ),
        "samples": (
            ("doe", "--points", "lhs", "--number", "99999999", "--parameter", "morph.xi1=0:1"),
            "--number = 99999999; allowed: 1 to 100000",
        ),
    }.values(),
)
def test_what_is_typed_is_refused_in_one_line(
    arguments: tuple[str, ...], said: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert said in _refused(capfd, *arguments)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("deep.toml", f"a = {20_000 * '['}{20_000 * ']'}", "tables or lists too deep"),
        ("deep.json", f'{{"config": {20_000 * "["}{20_000 * "]"}}}', "tables or lists too deep"),
        ("digits.toml", f"[finger]\nwall_mm = {DIGITS}", "finger.wall_mm: a number of 401 digits"),
    ],
)
def test_a_configuration_is_refused_in_one_line(
    name: str, text: str, said: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (folder / name).write_text(text)
    assert said in _refused(capfd, "config", "--config", name)


@pytest.mark.parametrize("command", [("bend", "--protocol"), ("plan-experiment",), ("design",)])
def test_other_files_are_refused_in_one_line(
    command: tuple[str, ...], folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (folder / "deep.toml").write_text(f"a = {20_000 * '['}{20_000 * ']'}")
    assert "tables or lists too deep" in _refused(capfd, *command, "deep.toml")


def test_an_unexpected_error_is_one_line_and_its_traceback_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def broken(asked: object) -> None:
        raise ZeroDivisionError("by\nnothing")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(reference_commands, "columns", broken)
    said = _refused(capfd, "columns", code=70)
    assert said.startswith(r"dolfingrip: ZeroDivisionError: by\nnothing; this is a fault")
    log = Path(re.findall(r"with its traceback, (\S+)", said)[0])
    assert log.is_relative_to(tmp_path)
    text = log.read_text(encoding="utf-8")
    assert "columns" in text
    assert text.endswith("ZeroDivisionError: by\nnothing\n")


def test_a_traceback_that_cannot_be_written_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(Subcommand, "function", lambda self: 1 / 0)
    assert "its traceback cannot be written" in _refused(capfd, "columns", code=70)


def test_a_full_output_is_one_line() -> None:
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [*COMMAND, "columns", "bend"], stdout=full, stderr=subprocess.PIPE, text=True,
            check=False,
        )  # fmt: skip
    assert ended.returncode == 1
    line = "dolfingrip: standard output: cannot be written: No space left on device\n"
    assert ended.stderr == line


def test_an_output_of_ascii_spells_what_it_cannot_have() -> None:
    ended = subprocess.run(
        [*COMMAND, "morph", "--help"], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii", "COLUMNS": "120"},
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (0, "")
    assert r"\u03be1" in ended.stdout


def test_a_command_that_computes_needs_no_home(tmp_path: Path) -> None:
    """As under cron: Open MPI would end the process in thirty lines."""
    given = {key: value for key, value in os.environ.items() if key != "HOME"}
    ended = subprocess.run(
        [*COMMAND, "mesh", "--out", tmp_path / "out", "--set", "mesh.size_mm=8", "--set",
         "mesh.edge_size_mm=8", "--set", "finger.length_mm=38", "--set", "finger.bellows=2"],
        capture_output=True, text=True, check=False,
        env={**given, "XDG_CACHE_HOME": str(tmp_path / "cache")},
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (tmp_path / "out" / "finger.msh").exists()


@pytest.mark.parametrize("interrupted", [False, True])
def test_ranks_wait_for_what_rank_0_prints(
    interrupted: bool, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """mpirun ends all ranks once one has failed; an interrupt may be one rank's alone."""
    waited: list[str] = []

    class World:
        rank, size = 0, 2

        def Barrier(self) -> None:
            waited.append("all")

    def ended(*given: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("dolfingrip.cli.edge._world", World)
    if interrupted:
        monkeypatch.setattr(Subcommand, "function", ended)
    assert run_command("columns", "nothing") == (130 if interrupted else 2)
    assert waited == ([] if interrupted else ["all"])

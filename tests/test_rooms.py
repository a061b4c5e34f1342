"""Folders that can be taken out: without one the rest imports, and its commands are listed."""

from __future__ import annotations

import subprocess
import sys

import pytest

from dolfingrip.cli.command import Subcommand
from dolfingrip.cli.commands import ALL, COMMANDS

HEAVY = (
    "cv2", "distributed", "gmsh", "matplotlib.pyplot", "pyvista", "scipy.optimize", "scipy.stats",
    "torch", "ufl",
)  # fmt: skip
"""Libraries that take seconds to import: once, before the process forks for each folder. They start
no threads, as MPI and pandas do."""
WITHOUT = """
import importlib, os, pkgutil, sys, traceback
for name in {heavy!r}:
    importlib.import_module(name)
class Hiding:
    def __init__(self, finder, missing):
        self.finder, self.missing = finder, missing
    def __getattr__(self, name):
        return getattr(self.finder, name)
    def find_spec(self, name, path=None, target=None):
        hidden = (name + ".").startswith(self.missing)
        return None if hidden else self.finder.find_spec(name, path, target)
def without(missing, needing):
    sys.meta_path[:] = [Hiding(finder, missing) for finder in sys.meta_path]
    import dolfingrip
    from dolfingrip.cli.commands import COMMANDS
    print(*(each.name for each in COMMANDS))
    for each in pkgutil.walk_packages(dolfingrip.__path__, "dolfingrip."):
        if not (each.name + ".").startswith((*needing, "dolfingrip.__main__.")):
            importlib.import_module(each.name)
    for each in COMMANDS:
        each.function()
for room, missing, needing in {rooms!r}:
    if not (child := os.fork()):
        os.dup2(os.open(room, os.O_CREAT | os.O_WRONLY), 1)
        os.dup2(1, 2)
        code = 1
        try:
            without(missing, needing)
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            os._exit(code)
    print(room, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
NAMES = sorted({room for command in ALL for room in command.rooms})


def needing(room: str) -> tuple[str, ...]:
    """Modules that cannot be there without a folder: its own, and those that need it."""
    above = {command.rooms[0] for command in ALL if room in command.rooms}
    files = {file(command) for command in ALL if room in command.rooms}
    return tuple(
        [f"dolfingrip.{each}." for each in sorted({room, *above})]
        + [f"dolfingrip.cli.{name}." for name in sorted(files)]
    )


def file(command: Subcommand) -> str:
    """File of the command's work."""
    return command.work.partition(":")[0]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[int, str]]:
    """Exit code of a process without a folder, and what it said, by the folder."""
    place = tmp_path_factory.mktemp("rooms")
    rooms = [(room, f"dolfingrip.{room}.", needing(room)) for room in NAMES]
    code = WITHOUT.format(heavy=HEAVY, rooms=rooms)
    ended = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=place, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    codes = dict(line.split() for line in ended.stdout.splitlines())
    return {room: (int(code), (place / room).read_text("utf-8")) for room, code in codes.items()}


@pytest.mark.slow
@pytest.mark.parametrize("room", NAMES)
def test_without_a_folder_the_rest_is_there(room: str, told: dict[str, tuple[int, str]]) -> None:
    code, said = told[room]
    assert code == 0, said
    listed = said.splitlines()[0].split()
    assert listed == [command.name for command in ALL if room not in command.rooms]
    assert len(listed) < len(ALL)


def test_commands_of_one_file_need_the_same_folders() -> None:
    """A file whose imports fail without a folder takes all of its commands with it."""
    of_file: dict[str, set[tuple[str, ...]]] = {}
    for command in ALL:
        of_file.setdefault(file(command), set()).add(command.rooms)
    assert {name: rooms for name, rooms in of_file.items() if len(rooms) > 1} == {}


def test_all_folders_are_there() -> None:
    assert {"diagnose", "design", "robot", "explore", "export", "import", "track"} <= {
        each.name for each in COMMANDS
    }

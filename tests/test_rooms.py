"""Folders that can be taken out: without one the rest imports, and its commands are listed."""

from __future__ import annotations

import subprocess
import sys

import pytest

from dolfingrip.cli.command import Subcommand
from dolfingrip.cli.commands import ALL, COMMANDS

WITHOUT = """
import importlib, pkgutil, sys
class Hiding:
    def __init__(self, finder):
        self.finder = finder
    def __getattr__(self, name):
        return getattr(self.finder, name)
    def find_spec(self, name, path=None, target=None):
        hidden = (name + ".").startswith({missing!r})
        return None if hidden else self.finder.find_spec(name, path, target)
sys.meta_path[:] = [Hiding(finder) for finder in sys.meta_path]
import dolfingrip
from dolfingrip.cli.commands import COMMANDS
print(*(each.name for each in COMMANDS))
needing = {needing!r}
for each in pkgutil.walk_packages(dolfingrip.__path__, "dolfingrip."):
    if not (each.name + ".").startswith((*needing, "dolfingrip.__main__.")):
        importlib.import_module(each.name)
for each in COMMANDS:
    each.function()
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


@pytest.mark.slow
@pytest.mark.parametrize("room", NAMES)
def test_without_a_folder_the_rest_is_there(room: str) -> None:
    code = WITHOUT.format(missing=f"dolfingrip.{room}.", needing=needing(room))
    ended = subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    listed = ended.stdout.splitlines()[0].split()
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

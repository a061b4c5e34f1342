"""Folders that can be taken out: without one the rest imports, and its commands are listed."""

from __future__ import annotations

import subprocess
import sys

import pytest

from dolfingrip.cli.commands import COMMANDS
from dolfingrip.cli.rooms import ROOMS

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
sys.meta_path[:] = [Hiding(each) for each in sys.meta_path]
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
NAMES = sorted({room for rooms in ROOMS.values() for room in rooms})


def needing(room: str) -> tuple[str, ...]:
    """Modules that cannot be there without a folder: its own, and those that need it."""
    files = [file for file, rooms in ROOMS.items() if room in rooms]
    above = {rooms[0] for rooms in ROOMS.values() if room in rooms}
    return tuple(
        [f"dolfingrip.{each}." for each in sorted({room, *above})]
        + [f"dolfingrip.cli.{each}." for each in files]
    )


@pytest.mark.slow
@pytest.mark.parametrize("room", NAMES)
def test_without_a_folder_the_rest_is_there(room: str) -> None:
    code = WITHOUT.format(missing=f"dolfingrip.{room}.", needing=needing(room))
    ended = subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    listed = ended.stdout.splitlines()[0].split()
    gone = [file for file, rooms in ROOMS.items() if room in rooms]
    assert gone
    assert listed == [each.name for each in COMMANDS if each.work.partition(":")[0] not in gone]


def test_all_folders_are_there() -> None:
    assert {"diagnose", "design", "robot", "explore", "export", "import", "track"} <= {
        each.name for each in COMMANDS
    }

"""Folders of the package that may be taken out, and what then stays of the commands."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # which loads MPI
    from dolfingrip.cli.console import Screen

ROOMS = {
    "design_command": ("design",),
    "diagnosis_commands": ("diagnosis",),
    "doe_commands": ("design",),
    "explore_command": ("explore", "design", "diagnosis"),
    "export_command": ("exporting",),
    "import_command": ("importing", "diagnosis"),
    "loop_commands": ("design",),
    "pickup_commands": ("design",),
    "robot_command": ("robot",),
    "surrogate_commands": ("design",),
    "track_command": ("tracking", "importing", "diagnosis"),
}
"""Folders of the package that files of commands need, and that may be taken out."""


def is_there(file: str) -> bool:
    """Return whether all folders are there that a file of commands needs.

    Args:
        file: of this folder, without its suffix.
    """
    return all(find_spec(f"dolfingrip.{room}") is not None for room in ROOMS.get(file, ()))


def offered(files: Sequence[Path], command: str, screen: Screen, out: Path) -> list[Path]:
    """Offer to import tables, where the folder that imports is there; else return them as they are.

    Args:
        files, command, screen, out: as of :func:`dolfingrip.cli.import_command.offered`.

    Raises:
        ConfigError: one line, where nobody can be asked.
    """
    if not is_there("import_command"):
        return [*files]
    from dolfingrip.cli import import_command

    return import_command.offered(files, command, screen, out)

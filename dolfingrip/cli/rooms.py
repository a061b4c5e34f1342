"""What a command does by a folder of the package that may be taken out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dolfingrip.cli.commands import COMMANDS

if TYPE_CHECKING:  # which loads MPI
    from dolfingrip.cli.console import Screen


def offered(files: Sequence[Path], command: str, screen: Screen, out: Path) -> list[Path]:
    """Offer to import tables, where the folder that imports is there; else return them as they are.

    Args:
        files, command, screen, out: as of :func:`dolfingrip.cli.import_command.offered`.

    Raises:
        ConfigError: one line, where nobody can be asked.
    """
    if all(listed.name != "import" for listed in COMMANDS):
        return [*files]
    from dolfingrip.cli import import_command

    return import_command.offered(files, command, screen, out)

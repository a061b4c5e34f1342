"""The ``dolfingrip`` command."""

from __future__ import annotations

import sys
from typing import Any

from dolfingrip import plugins
from dolfingrip.cli import edge


def _command() -> Any:
    """The command; its options are made of what there is, which plugins add to."""
    sys.argv[1:] = plugins.taken(sys.argv[1:])
    import typer

    from dolfingrip.cli.commands import app

    return typer.main.get_command(app)


def main() -> None:
    """Run the command; :func:`dolfingrip.cli.edge.run` says what its exit codes are."""
    edge.run(_command)

"""The list of commands, from the command line itself."""

from __future__ import annotations

import typer
from click import Context
from docstrings import inline, table

from dolfingrip.cli.app import app


def listed() -> str:
    """A table of all commands with the first paragraph of their help."""
    group = typer.main.get_command(app)
    rows = [
        [f"`{name}`", inline((command.help or "").split("\n\n")[0])]
        for name in group.list_commands(Context(group))  # type: ignore[attr-defined]
        if not (command := group.commands[name]).hidden  # type: ignore[attr-defined]
    ]
    return table(["command", "what it does"], rows)

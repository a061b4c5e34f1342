"""What several commands share: their options, and where they print."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
from mpi4py import MPI
from rich.console import Console

ConfigFile = Annotated[
    Path | None,
    typer.Option("--config", "-c", help="TOML file, or a run.json to repeat; see `config`."),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", "-s", metavar="KEY=VALUE", help="e.g. finger.wall_mm=1.8; repeatable."),
]


def console() -> Console:
    """Where results are printed: silent on ranks other than 0."""
    bare = False if _redirected() else None  # None: rich finds out
    return Console(quiet=MPI.COMM_WORLD.rank != 0, highlight=False, force_terminal=bare)


def _redirected() -> bool:
    """Whether mpirun's output goes elsewhere than the terminal that it lets its ranks see."""
    if "PMIX_RANK" not in os.environ:
        return False
    try:
        return not os.readlink(f"/proc/{os.getppid()}/fd/1").startswith(("/dev/pts", "/dev/tty"))
    except OSError:
        return True

"""``dolfingrip export``: a design as STL, STEP or configuration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Overrides, check_writable, console
from dolfingrip.config import ConfigError
from dolfingrip.files import whole

CONFIGURATION = ".toml"


def export(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE…", help="Files ending in .stl, .step or .toml.")
    ],
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Write a design as STL or STEP, closed and ready to print, or as a configuration.

    --config takes a TOML file, or the run.json of an earlier run. The solid is the whole finger
    without load, in mm.
    """
    resolved = configuration.load(config, dict(overrides or ()))
    from dolfingrip.mechanics.model.domain import on_root
    from dolfingrip.report import printable

    allowed = (*printable.FORMATS, CONFIGURATION)
    for file in files:
        if file.suffix.lower() not in allowed:
            raise ConfigError(f"FILE {file}: allowed: names that end in {', '.join(allowed)}")
        check_writable(file.parent)
    screen = console()

    def work() -> None:
        for file in files:
            if file.suffix.lower() == CONFIGURATION:
                whole.write(file, configuration.dumps(resolved))
                screen.print(f"wrote {file}", soft_wrap=True)
                continue
            volume = printable.write(resolved, file)
            screen.print(f"wrote {file}: closed, {volume / 1000:.4g} cm³", soft_wrap=True)

    on_root(MPI.COMM_WORLD, work)

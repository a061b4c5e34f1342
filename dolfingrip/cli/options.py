"""Options that several commands share, and the console on which they print."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from mpi4py import MPI
from rich.console import Console

from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError

ConfigFile = Annotated[
    Path | None,
    typer.Option("--config", "-c", help="TOML file, or a run.json to repeat; see `config`."),
]


def assigned(option: typer.CallbackParam, texts: list[str] | None) -> Any:
    """Return the keys and values of an option's ``KEY=VALUE`` texts.

    Args:
        option: that errors name.
        texts: as typed; None where there are none.

    Raises:
        ConfigError: one line naming the option, where one is not an assignment.
    """
    return list(tables.assignments(texts or (), f"--{option.opts[0].lstrip('-')}").items())


def assigned_numbers(option: typer.CallbackParam, texts: list[str] | None) -> Any:
    """Return keys of the configuration and values, of which numbers are checked as parameters.

    Args:
        option: that errors name.
        texts: as typed; None where there are none.

    Raises:
        ConfigError: one line naming the option, the key, the value and the allowed range.
    """
    from dolfingrip.parameter import check

    found = assigned(option, texts)
    check(dict(found), f"--{option.opts[0].lstrip('-')}")
    return found


Overrides = Annotated[
    list[Any] | None,
    typer.Option(
        "--set",
        "-s",
        metavar="KEY=VALUE",
        help="e.g. finger.wall_mm=1.8; repeatable.",
        callback=assigned_numbers,
    ),
]
Noise = Annotated[
    list[Any] | None,
    typer.Option(
        "--noise",
        metavar="COLUMN=STD",
        help="Of a column's readings, e.g. angle_deg=0.2; repeatable.",
        callback=assigned,
    ),
]
Gradients = Annotated[
    bool,
    typer.Option("--gradients", help="Derive all readings by parameters: sensitivity.csv."),
]
Parameters = Annotated[
    str | None,
    typer.Option(
        "--parameters", metavar="KEY,KEY,…", help="Parameters of --gradients; default: all."
    ),
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for results.")]


def console() -> Console:
    """The console on which results are printed; it is silent on ranks other than 0.

    It prints text as it stands. Names of tables in files, as ``[film.NAME]``, look like rich's
    markup, and ``:x:`` in a path like an emoji. A colour is told by ``style=``.
    """
    bare = False if _redirected() else None  # None: rich finds out
    return Console(
        quiet=MPI.COMM_WORLD.rank != 0,
        highlight=False,
        markup=False,
        emoji=False,
        force_terminal=bare,
        file=sys.stdout,  # this one, as compiles of forms put another in its place
    )


def one_process(allowed: str) -> None:
    """Refuse to run under mpirun.

    Args:
        allowed: what is allowed instead.

    Raises:
        ConfigError: on every rank, if there are several.
    """
    if MPI.COMM_WORLD.size > 1:
        raise ConfigError(f"mpirun -n {MPI.COMM_WORLD.size}: allowed: {allowed}")


def gradient_keys(gradients: bool, parameters: str | None) -> list[str] | None:
    """Keys of parameters that readings are derived by; []: all parameters; None: no derivatives.

    Args:
        gradients: whether derivatives are asked for.
        parameters: keys of their parameters, joined by commas.

    Raises:
        ConfigError: one line, if keys are given and derivatives are not asked for.
    """
    if gradients:
        return [key.strip() for key in parameters.split(",")] if parameters else []
    if parameters is not None:
        raise ConfigError(f"--parameters {parameters}: allowed: with --gradients")
    return None


def _redirected() -> bool:
    """Whether mpirun's output is redirected, although its ranks see a terminal."""
    if "PMIX_RANK" not in os.environ:
        return False
    try:
        return not os.readlink(f"/proc/{os.getppid()}/fd/1").startswith(("/dev/pts", "/dev/tty"))
    except OSError:
        return True


def check_writable(out: Path) -> None:
    """Raise before anything is computed if results cannot be written; nothing is created.

    Args:
        out: folder for results, which need not be there.

    Raises:
        ConfigError: on every rank, if the folder cannot be made or written.
    """

    from dolfingrip.mechanics.model.domain import on_root

    def work() -> None:
        there = next(path for path in (out.absolute(), *out.absolute().parents) if path.exists())
        if not there.is_dir():
            raise ConfigError(f"--out {out}: {there} is a file; allowed: a folder")
        if not os.access(there, os.W_OK | os.X_OK):
            raise ConfigError(f"--out {out}: {there} is read-only; allowed: a writable folder")

    on_root(MPI.COMM_WORLD, work)

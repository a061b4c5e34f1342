"""The console on which commands print, and what they check before they begin."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from mpi4py import MPI
from rich.console import Console

from dolfingrip.jobs.interrupts import Interrupted
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.sections.errors import ConfigError

UNCUT = 10_000
"""Characters of a line where there is no terminal."""


class Screen(Console):
    """A console that prints text as it stands.

    Names of tables in files, as ``[film.NAME]``, look like rich's markup, and ``:x:`` in a path
    like an emoji. A colour is told by ``style=``.
    """

    def say(self, text: str, style: str | None = None, end: str = "\n") -> None:
        """Print a text, whose lines are not cut to the width of the terminal."""
        self.print(text, style=style, end=end, soft_wrap=True)


def console() -> Screen:
    """Return the console on which results are printed; it is silent on ranks other than 0."""
    bare = False if _redirected() else None  # None: rich finds out
    screen = Screen(
        quiet=MPI.COMM_WORLD.rank != 0,
        highlight=False,
        markup=False,
        emoji=False,
        force_terminal=bare,
        file=sys.stdout,  # this one, as compiles of forms put another in its place
    )
    if not screen.is_terminal and "COLUMNS" not in os.environ:
        screen.width = UNCUT  # a file or a pipe has no width; rich would break lines at 80
    return screen


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
    """True where mpirun's output is redirected, although its ranks see a terminal."""
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

    def work() -> None:
        try:
            there = next(
                path for path in (out.absolute(), *out.absolute().parents) if path.exists()
            )
        except OSError as error:
            raise ConfigError(f"--out {out}: {error.strerror}; allowed: another folder") from None
        if not there.is_dir():
            raise ConfigError(f"--out {out}: {there} is a file; allowed: a folder")
        if not os.access(there, os.W_OK | os.X_OK):
            raise ConfigError(f"--out {out}: {there} is read-only; allowed: a writable folder")

    on_root(MPI.COMM_WORLD, work)


@contextmanager
def resumable(screen: Console, folder: Path) -> Iterator[None]:
    """Say what is kept where a command is interrupted, or where not all jobs can be computed.

    Args:
        screen: where the second is said; the command then ends with code 1.
        folder: of the jobs.
    """
    try:
        yield
    except Unfinished as ending:
        screen.print(str(ending), style="red", soft_wrap=True)
        raise typer.Exit(1) from None
    except KeyboardInterrupt:
        if not folder.is_dir() or not any(folder.iterdir()):
            raise Interrupted("nothing is computed yet") from None
        raise Interrupted(
            f"what was computed is kept in {folder}; the same command goes on from there"
        ) from None

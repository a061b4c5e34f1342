"""The ``dolfingrip`` command: its subcommands, each imported when it is asked for."""

from __future__ import annotations

import importlib
import logging
import os
import sys
from collections.abc import Iterator, Mapping
from copy import copy
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

import dolfingrip
from dolfingrip.cli import listing
from dolfingrip.cli.pipes import unbroken_output

LAUNCHERS = {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID"}
"""Environment variables by which a process knows that it is one of several ranks."""


class Subcommands(Mapping[str, Any]):
    """The subcommands by name, imported when one is asked for."""

    def __init__(self) -> None:
        self._loaded: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._loaded:
            self._loaded[name] = _loaded(name)
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter(listing.names())

    def __len__(self) -> int:
        return len(listing.names())


def _loaded(name: str) -> Any:
    """Import a subcommand; a KeyError tells that there is none of this name."""
    single = typer.Typer(add_completion=False)
    if name in listing.HOME:
        module, function = listing.HOME[name]
        home = importlib.import_module(f"dolfingrip.cli.{module}")
        if hasattr(home, "app"):  # it has subcommands of its own
            single = home.app
        else:
            single.command(name)(getattr(home, function))
    elif name in listing.experiments():
        home = importlib.import_module("dolfingrip.cli.experiment_commands")
        home.register(single, name)
    else:
        raise KeyError(name)
    command = typer.main.get_command(single)
    command.name = name
    return command


class Lazy(TyperGroup):
    """Lists subcommands in the order of use, and imports none of them for that."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings | {"commands": {}})
        self.commands = Subcommands()  # type: ignore[assignment]

    def list_commands(self, ctx: typer.Context) -> list[str]:  # type: ignore[override]
        """Names of the subcommands."""
        return listing.names()

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, with the summaries of subcommands alone."""
        listed = copy(self)
        listed.commands = {
            name: TyperCommand(name, help=listing.summary(name)) for name in listing.names()
        }
        super(Lazy, listed).format_help(ctx, formatter)


app = typer.Typer(
    cls=Lazy,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Simulate 3D-printed pneumatic gripper fingers.",
)


def _print_version(asked: bool) -> None:
    """Print the version and exit if ``--version`` is given."""
    if asked:
        sys.stdout.write(f"dolfingrip {dolfingrip.__version__}\n")
        raise typer.Exit


@app.callback()
def _start(
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Log details.")] = False,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    level = logging.INFO if verbose else logging.WARNING
    logging.basicConfig(
        level=logging.CRITICAL if _rank() else level, format="%(message)s", stream=sys.stderr
    )


def main() -> None:
    """Run the command.

    The exit code is 0 after success, 1 if a load path ended early (the results up to there are
    kept, and a sentence says why it ended), the machine failed, or a file could not be written (one
    line says which and why, and what was there before is untouched), 2 after bad input, which one
    line names, and 130 after Ctrl-C. A closed output pipe does not change it.
    """
    with unbroken_output():
        errors = sys.stderr
        if LAUNCHERS & os.environ.keys():
            _rank()
        try:
            app()
        except (Exception, SystemExit) as ending:
            from dolfingrip.cli.endings import end

            end(ending, errors)


def _rank() -> int:
    """This process' rank; from here on rank 0 alone prints, also errors that all ranks have."""
    try:
        from mpi4py import MPI
    except ImportError:  # `doctor` says so, and what needs it fails
        return 0
    if MPI.COMM_WORLD.rank and getattr(sys.stdout, "name", "") != os.devnull:
        sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    return int(MPI.COMM_WORLD.rank)

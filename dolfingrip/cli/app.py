"""The ``dolfingrip`` command: its subcommands in the order of use, its exit codes."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from mpi4py import MPI
from typer.core import TyperGroup

from dolfingrip import __version__
from dolfingrip import config as configuration
from dolfingrip.cli import (
    adopt_command,
    columns_command,
    design_command,
    diagnose_command,
    doe_commands,
    experiment_commands,
    explore_command,
    export_command,
    extensions_command,
    mesh_command,
    morph_command,
    optimise_command,
    pickup_commands,
    plan_command,
    predict_command,
    report_command,
    reproduce_command,
    study_command,
    train_command,
)
from dolfingrip.cli.options import INTERRUPTED, ConfigFile, Overrides
from dolfingrip.cli.pipes import unbroken_output
from dolfingrip.config import ConfigError
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.files.result_file import ResultFileError
from dolfingrip.files.whole import FULL, WriteError, failed
from dolfingrip.jobs.interrupts import interrupt_behind
from dolfingrip.sections.errors import MachineError

ORDER = (
    "demo",
    *(experiment.command for experiment in EXPERIMENTS.values()),
    *("pickup", "friction", "adopt", "mesh", "export", "morph", "config", "columns", "extensions"),
    *("synthetic", "diagnose", "plan-experiment", "predict"),
    *("design", "doe", "train", "optimise", "study", "reproduce"),
    *("report", "explore"),
)
"""Subcommands in the order in which a new user needs them."""


class InOrder(TyperGroup):
    """Lists subcommands in :data:`ORDER`; typer itself puts groups such as ``doe`` last."""

    def list_commands(self, ctx: typer.Context) -> list[str]:  # type: ignore[override]
        """Names of the subcommands; those that :data:`ORDER` lacks stand at the end."""
        known = {name: place for place, name in enumerate(ORDER)}
        return sorted(self.commands, key=lambda name: known.get(name, len(ORDER)))


app = typer.Typer(
    cls=InOrder,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Simulate 3D-printed pneumatic gripper fingers.",
)
app.command("demo")(experiment_commands.demo)
experiment_commands.register(app)
for _name, _command in pickup_commands.COMMANDS.items():
    app.command(_name)(_command)
app.command("synthetic")(experiment_commands.synthetic_measurement)
app.command("diagnose")(diagnose_command.diagnose)
app.command("plan-experiment")(plan_command.plan_experiment)
app.command("predict")(predict_command.predict)
app.command("adopt")(adopt_command.adopt)
app.command("mesh")(mesh_command.mesh)
app.command("export")(export_command.export)
app.command("morph")(morph_command.morph)
app.command("columns")(columns_command.columns)
app.command("extensions")(extensions_command.extensions)
app.command("design")(design_command.design)
app.add_typer(doe_commands.app, name="doe")
app.command("train")(train_command.train)
app.command("optimise")(optimise_command.optimise)
app.command("study")(study_command.study)
app.command("reproduce")(reproduce_command.reproduce)
app.command("report")(report_command.report)
app.command("explore")(explore_command.explore)


def _print_version(asked: bool) -> None:
    """Print the version and exit if ``--version`` is given."""
    if asked:
        sys.stdout.write(f"dolfingrip {__version__}\n")
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
    root = MPI.COMM_WORLD.rank == 0
    level = (logging.INFO if verbose else logging.WARNING) if root else logging.CRITICAL
    logging.basicConfig(level=level, format="%(message)s", stream=sys.stderr)


@app.command("config")
def show_config(config: ConfigFile = None, overrides: Overrides = None) -> None:
    """Print the resolved configuration, each key with its meaning."""
    resolved = configuration.load(config, dict(overrides or ()))
    if MPI.COMM_WORLD.rank == 0:
        sys.stdout.write(configuration.dumps(resolved))


def main() -> None:
    """Run the command.

    The exit code is 0 after success, 1 if a load path ended early (the results up to there are
    kept, and a sentence says why it ended), the machine failed, or a file could not be written (one
    line says which and why, and what was there before is untouched), 2 after bad input, which one
    line names, and 130 after Ctrl-C. A closed output pipe does not change it.
    """
    with unbroken_output():
        _main()


def _main() -> None:
    comm = MPI.COMM_WORLD
    errors = sys.stderr
    if comm.rank:  # rank 0 alone prints errors that all ranks have
        sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    try:
        app()
    except (ConfigError, ResultFileError) as error:  # the same on all ranks
        sys.stderr.write(f"dolfingrip: {error}\n")
        _end(2)
    except MachineError as error:
        sys.stderr.write(f"dolfingrip: {error}\n")
        sys.stderr.flush()
        if comm.size > 1:  # it may be on this rank alone
            comm.Abort(1)
        _end(1)
    except SystemExit as ending:
        if ending.code == INTERRUPTED:
            _say_interrupted(ending)
        _end(ending.code)
    except WriteError as error:  # on all ranks, too
        sys.stderr.write(f"dolfingrip: {error}\n")
        _end(1)
    except Exception as error:
        if interrupt_behind(error):
            _say_interrupted(error)
            _end(INTERRUPTED)
        if comm.size == 1:
            if isinstance(error, OSError) and error.errno in FULL and error.filename:
                sys.stderr.write(f"dolfingrip: {failed(Path(error.filename), error)}\n")
                _end(1)
            raise
        # without this the other ranks would wait for this one for ever
        traceback.print_exc(file=errors)
        errors.flush()
        comm.Abort(70)


def _end(code: object) -> NoReturn:
    """Exit on all ranks after rank 0 has printed; mpirun kills all ranks as soon as one fails."""
    sys.stdout.flush()
    sys.stderr.flush()
    if code and code != INTERRUPTED:  # an interrupt may have reached this rank alone
        MPI.COMM_WORLD.Barrier()
    sys.exit(code)  # type: ignore[arg-type]


def _say_interrupted(error: BaseException) -> None:
    """Say in one line what an interrupted command kept, and how to go on."""
    said = interrupt_behind(error)
    sentence = str(said) if said and said.args else "the same command starts from the beginning"
    sys.stderr.write(f"dolfingrip: interrupted: {sentence}\n")

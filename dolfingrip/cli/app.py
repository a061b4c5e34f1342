"""The ``dolfingrip`` command."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli import (
    doe_commands,
    experiment_command,
    morph_command,
    optimise_command,
    reproduce_command,
    study_command,
    train_command,
)
from dolfingrip.cli import extensions_command as listing
from dolfingrip.cli.experiment_command import ProtocolOption
from dolfingrip.cli.options import ConfigFile, Overrides, console
from dolfingrip.config import ConfigError
from dolfingrip.experiments.index import find

INTERRUPTED = 130
"""Exit code after Ctrl-C, as of shells."""

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Simulate 3D-printed pneumatic gripper fingers.",
)

experiment_command.register(app)
app.command("morph")(morph_command.morph)
app.add_typer(doe_commands.app, name="doe")
app.command("train")(train_command.train)
app.command("optimise")(optimise_command.optimise)
app.command("study")(study_command.study)
app.command("reproduce")(reproduce_command.reproduce)
app.command("extensions")(listing.extensions)


@app.callback()
def _log(
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Log details.")] = False,
) -> None:
    root = MPI.COMM_WORLD.rank == 0
    level = (logging.INFO if verbose else logging.WARNING) if root else logging.CRITICAL
    logging.basicConfig(level=level, format="%(message)s", stream=sys.stderr)


@app.command("config")
def show_config(config: ConfigFile = None, overrides: Overrides = None) -> None:
    """Print the resolved configuration, each key with its meaning."""
    resolved = configuration.load(config, overrides or ())
    if MPI.COMM_WORLD.rank == 0:
        sys.stdout.write(configuration.dumps(resolved))


@app.command()
def mesh(
    out: Annotated[Path, typer.Option(help="Folder for the mesh files.")] = Path("out/mesh"),
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Mesh the finger: .msh, VTK and Abaqus .inp."""
    from dolfingrip.cli.commands import write_mesh

    write_mesh(configuration.load(config, overrides or ()), out, console())


@app.command()
def fake(
    out: Annotated[Path, typer.Option(help="Folder for the data set.")] = Path("out/fake"),
    experiments: Annotated[
        str, typer.Option(help="Which, as in bending,blocked_force.")
    ] = "bending,blocked_force",
    config: ConfigFile = None,
    overrides: Overrides = None,
    hide: Annotated[
        list[str] | None,
        typer.Option("--hide", metavar="KEY=VALUE", help="As --set, but not told; repeatable."),
    ] = None,
    nuisance: Annotated[
        list[str] | None,
        typer.Option("--nuisance", metavar="EFFECT", help="On, drawn from its prior; repeatable."),
    ] = None,
    noise: Annotated[
        list[str] | None,
        typer.Option("--noise", metavar="COLUMN=VALUE", help="Standard deviation; repeatable."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of nuisances and noise.")] = 0,
    protocol: ProtocolOption = None,
) -> None:
    """Synthetic measurement: hidden effects, nuisances and noise, in the measured-data format."""
    from dolfingrip.cli.commands import synthetic_measurement

    first = find(experiments.partition(",")[0], "--experiments")
    told = experiment_command.poses(first, config, overrides, out, protocol)
    for folder, resolved in told:
        truth = resolved.overridden(hide or ())
        synthetic_measurement(
            experiments, resolved, truth, nuisance or (), noise or (), seed, folder, console()
        )


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("out/demo"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    loop: Annotated[bool, typer.Option(help="With the small design loop.")] = True,
) -> None:
    """Both experiments on the reference finger, a table, plots, renders, a small design loop."""
    from dolfingrip.cli.commands import run_demo

    resolved = configuration.load(config, overrides or ())
    results = run_demo(resolved, out, console())
    if loop and MPI.COMM_WORLD.size > 1:
        console().print("no design loop under mpirun: it starts processes of its own")
    elif loop:
        from dolfingrip.cli import small_loop

        small_loop.run(resolved, out / "loop")
    experiment_command.end(*results)


def main() -> None:
    """Run the command.

    Exit codes: 0; 1 where a load path ended early (what was reached is kept, and a sentence
    says why it ended); 2 with one line for bad input; 130 where interrupted.
    """
    comm = MPI.COMM_WORLD
    errors = sys.stderr
    if comm.rank:  # what concerns all is said once
        sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    try:
        app()
    except ConfigError as error:  # the same on all ranks
        sys.stderr.write(f"dolfingrip: {error}\n")
        _end(2)
    except SystemExit as ending:
        _end(ending.code)
    except Exception as error:
        if _interrupted(error):
            _end(INTERRUPTED)
        if comm.size == 1:
            raise
        # the other ranks would wait for this one for ever
        traceback.print_exc(file=errors)
        errors.flush()
        comm.Abort(70)


def _end(code: object) -> NoReturn:
    """Exit on all ranks, the text of rank 0 first: mpirun kills the rest as one rank fails."""
    sys.stdout.flush()
    sys.stderr.flush()
    if code and code != INTERRUPTED:  # an interrupt may have reached this rank alone
        MPI.COMM_WORLD.Barrier()
    sys.exit(code)  # type: ignore[arg-type]


def _interrupted(error: BaseException) -> bool:
    """Whether Ctrl-C is behind an error: PETSc passes it on from a callback as its own."""
    behind = error.__cause__ or error.__context__
    return isinstance(error, KeyboardInterrupt) or (behind is not None and _interrupted(behind))

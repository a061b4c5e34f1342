"""The ``dolfingrip`` command."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli import (
    doe_commands,
    morph_command,
    optimise_command,
    reproduce_command,
    study_command,
    train_command,
)
from dolfingrip.cli import extensions_command as listing
from dolfingrip.cli.options import ConfigFile, Overrides, console
from dolfingrip.config import Config, ConfigError
from dolfingrip.sections import protocol_file as protocols

if TYPE_CHECKING:
    from dolfingrip.experiments.run import Kind, Result

INTERRUPTED = 130
"""Exit code after Ctrl-C, as of shells."""

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Simulate 3D-printed pneumatic gripper fingers.",
)

Renders = Annotated[
    str | None,
    typer.Option("--render", metavar="kPa,kPa,…", help="Pressures to render, e.g. 0,100,200."),
]
Colour = Annotated[
    str, typer.Option("--colour-by", help="Colour renders by displacement or stretch.")
]


ProtocolOption = Annotated[
    Path | None,
    typer.Option("--protocol", help="TOML of ramps and waits, or a measurement's CSV."),
]


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
def bend(
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("out/bend"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    render: Renders = None,
    colour_by: Colour = "displacement",
    protocol: ProtocolOption = None,
) -> None:
    """Free bending: the tip's angle against pressure."""
    _experiment("bending", config, overrides, out, render, colour_by, protocol)


@app.command()
def force(
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("out/force"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    render: Renders = None,
    colour_by: Colour = "displacement",
    protocol: ProtocolOption = None,
) -> None:
    """Blocked force: the tip against the force sensor's plate."""
    _experiment("blocked_force", config, overrides, out, render, colour_by, protocol)


@app.command()
def cycle(
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("out/cycle"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    cycles: Annotated[int, typer.Option(help="How often up and down.")] = 2,
    pressure: Annotated[
        float | None, typer.Option("--pressure-kPa", help="Highest pressure (kPa).")
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate-kPa-per-s", help="Of the ramps (kPa/s).")
    ] = None,
    hold: Annotated[
        float | None, typer.Option("--hold-s", help="Wait at the highest pressure (s).")
    ] = None,
    blocked: Annotated[
        bool, typer.Option("--blocked", help="Against the force sensor's plate.")
    ] = False,
    render: Renders = None,
    colour_by: Colour = "displacement",
) -> None:
    """Pressurise and vent again and again."""
    asked = {
        "cycles": cycles,
        "max_pressure_kPa": pressure,
        "rate_kPa_per_s": rate,
        "hold_s": hold,
        "unload": "true",
    }
    more = [f"experiment.{key}={value}" for key, value in asked.items() if value is not None]
    kind: Kind = "blocked_force" if blocked else "bending"
    _experiment(kind, config, [*(overrides or ()), *more], out, render, colour_by, None)


@app.command()
def coupon(
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("out/coupon"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    protocol: ProtocolOption = None,
) -> None:
    """Uniaxial tension of the material: nominal stress against strain."""
    from dolfingrip.cli.commands import run_coupon

    poses = _poses("coupon", config, overrides, out, protocol)
    _exit(*[run_coupon(resolved, folder, console()) for folder, resolved in poses])


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
    from dolfingrip.cli.commands import fake_measurement

    told = _poses(experiments.partition(",")[0], config, overrides, out, protocol)
    for folder, resolved in told:
        truth = resolved.overridden(hide or ())
        fake_measurement(
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
    _exit(*results)


def _experiment(
    kind: Kind,
    config: Path | None,
    overrides: list[str] | None,
    out: Path,
    render: str | None,
    colour_by: str,
    protocol: Path | None,
) -> None:
    from dolfingrip.cli.commands import run_experiment

    poses = _poses(kind, config, overrides, out, protocol)
    _exit(
        *[
            run_experiment(kind, resolved, folder, render, colour_by, console())
            for folder, resolved in poses
        ]
    )


def _poses(
    experiment: str,
    config: Path | None,
    overrides: list[str] | None,
    out: Path,
    protocol: Path | None,
) -> list[tuple[Path, Config]]:
    """Folder and configuration of each set-up that the protocol asks for."""
    if protocol is None:
        return [(out, configuration.load(config, overrides or ()))]
    table, poses = protocols.read(protocol, experiment)
    settings = [
        (out / pose.name, configuration.load(config, [*(overrides or ()), *pose.set]))
        for pose in poses
    ] or [(out, configuration.load(config, overrides or ()))]
    return [(folder, resolved.changed(protocol=table)) for folder, resolved in settings]


def _exit(*results: Result) -> None:
    """Exit code 1 where a load path ended early, its results up to there being kept."""
    if any(result.failure is not None for result in results):
        raise typer.Exit(1)


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

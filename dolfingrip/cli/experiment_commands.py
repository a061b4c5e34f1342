"""Options of ``dolfingrip demo``, ``bend``, ``force``, ``cycle``, ``coupon`` and ``fake``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, console
from dolfingrip.config import Config, ConfigError
from dolfingrip.sections import protocol_file

if TYPE_CHECKING:
    from dolfingrip.experiments.run import Kind, Result

Renders = Annotated[
    str | None,
    typer.Option("--render", metavar="kPa,kPa,…", help="Draw the finger at these, e.g. 0,100,200."),
]
Colour = Annotated[
    str, typer.Option("--colour-by", help="Colours of these pictures: displacement or stretch.")
]
ProtocolOption = Annotated[
    Path | None,
    typer.Option("--protocol", help="TOML of ramps and waits, or a measurement's CSV."),
]
Specimen = Annotated[
    str | None,
    typer.Option("--specimen", metavar="NAME", help="Specimen in the CSV of --protocol."),
]


def _one_experiment(kind: Kind, name: str, summary: str) -> Callable[..., None]:
    """The command ``name``, which runs experiment ``kind``."""

    def command(
        out: Out = Path("out") / name,
        config: ConfigFile = None,
        overrides: Overrides = None,
        render: Renders = None,
        colour_by: Colour = "displacement",
        protocol: ProtocolOption = None,
        specimen: Specimen = None,
    ) -> None:
        poses = _poses(kind, config, overrides, out, protocol, specimen)
        _run(kind, poses, render, colour_by)

    command.__name__, command.__doc__ = name, summary
    return command


bend = _one_experiment(
    "bending", "bend", "Bend the finger freely: the tip's angle against pressure."
)
force = _one_experiment(
    "blocked_force",
    "force",
    "Press the tip on the force sensor's plate: blocked force against pressure.",
)


def cycle(
    out: Out = Path("out/cycle"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    cycles: Annotated[int, typer.Option(help="Number of times up and down.")] = 2,
    pressure: Annotated[
        float | None, typer.Option("--pressure-kPa", help="Highest pressure (kPa).")
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate-kPa-per-s", help="Rate of the ramps (kPa/s).")
    ] = None,
    hold: Annotated[
        float | None,
        typer.Option("--hold-s", help="Length of the wait at the highest pressure (s)."),
    ] = None,
    blocked: Annotated[
        bool, typer.Option("--blocked", help="Press on the force sensor's plate.")
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
    poses = _poses(kind, config, [*(overrides or ()), *more], out)
    _run(kind, poses, render, colour_by)


def coupon(
    out: Out = Path("out/coupon"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    protocol: ProtocolOption = None,
    specimen: Specimen = None,
) -> None:
    """Pull the material in uniaxial tension: nominal stress against strain."""
    from dolfingrip.cli.commands import run_coupon

    poses = _poses("coupon", config, overrides, out, protocol, specimen)
    _exit(*[run_coupon(resolved, folder, console()) for folder, resolved in poses])


def fake(
    out: Out = Path("out/fake"),
    experiments: Annotated[
        str, typer.Option(help="Experiments to simulate, joined by commas.")
    ] = "bending,blocked_force",
    config: ConfigFile = None,
    overrides: Overrides = None,
    hide: Annotated[
        list[str] | None,
        typer.Option(
            "--hide", metavar="KEY=VALUE", help="Like --set, but kept secret; repeatable."
        ),
    ] = None,
    nuisance: Annotated[
        list[str] | None,
        typer.Option(
            "--nuisance", metavar="EFFECT", help="Draw its values from its prior; repeatable."
        ),
    ] = None,
    noise: Annotated[
        list[str] | None,
        typer.Option(
            "--noise", metavar="COLUMN=VALUE", help="Standard deviation of noise; repeatable."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of nuisances and noise.")] = 0,
    protocol: ProtocolOption = None,
    specimen: Specimen = None,
) -> None:
    """Write a synthetic measurement with hidden effects, nuisances and noise."""
    from dolfingrip.cli.commands import fake_measurement

    first = experiments.partition(",")[0]
    for folder, resolved in _poses(first, config, overrides, out, protocol, specimen):
        truth = resolved.overridden(hide or ())
        fake_measurement(
            experiments, resolved, truth, nuisance or (), noise or (), seed, folder, console()
        )


def demo(
    out: Out = Path("out/demo"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    loop: Annotated[bool, typer.Option(help="Run the small design loop, too.")] = True,
) -> None:
    """Run both experiments on the reference finger, draw them, run a small design loop."""
    from dolfingrip.cli.commands import run_demo

    resolved = configuration.load(config, overrides or ())
    results = run_demo(resolved, out, console())
    if loop and MPI.COMM_WORLD.size > 1:
        console().print("no design loop under mpirun: it starts processes of its own")
    elif loop:
        from dolfingrip.cli import small_loop

        small_loop.run(resolved, out / "loop")
    _exit(*results)


def _poses(
    experiment: str,
    config: Path | None,
    overrides: list[str] | None,
    out: Path,
    protocol: Path | None = None,
    specimen: str | None = None,
) -> list[tuple[Path, Config]]:
    """Folder and configuration of each set-up that the protocol asks for."""
    assignments = overrides or []
    if protocol is None:
        if specimen is not None:
            raise ConfigError(f"--specimen {specimen}: allowed: with --protocol FILE.csv")
        return [(out, configuration.load(config, assignments))]
    table, poses = protocol_file.read(protocol, experiment, specimen)
    settings = [
        (out / pose.name, configuration.load(config, [*assignments, *pose.set])) for pose in poses
    ] or [(out, configuration.load(config, assignments))]
    return [(folder, resolved.changed(protocol=table)) for folder, resolved in settings]


def _run(kind: Kind, poses: list[tuple[Path, Config]], render: str | None, colour_by: str) -> None:
    """Run an experiment in each set-up, one after another."""
    from dolfingrip.cli.commands import run_experiment

    _exit(
        *[
            run_experiment(kind, resolved, folder, render, colour_by, console())
            for folder, resolved in poses
        ]
    )


def _exit(*results: Result) -> None:
    """Exit code 1 where a load path ended early, its results up to there being kept."""
    if any(result.failure is not None for result in results):
        raise typer.Exit(1)

"""The commands of the experiments, made from their descriptions; ``synthetic`` and ``demo``."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import (
    ConfigFile,
    Gradients,
    Noise,
    Out,
    Overrides,
    Parameters,
    assigned_numbers,
    console,
    gradient_keys,
)
from dolfingrip.config import Change, ConfigError, changed
from dolfingrip.experiments.description import PRESSURE_OPTION, Option
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS, find

if TYPE_CHECKING:
    from dolfingrip.experiments.result import Result

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


def register(app: typer.Typer, command: str) -> None:
    """Give ``app`` the subcommand of one experiment of the index."""
    experiment = find(command)
    app.command(command, help=experiment.summary())(_command(experiment))


def synthetic_measurement(
    out: Out = Path("out/synthetic"),
    experiments: Annotated[
        str, typer.Option(help="Experiments to simulate, joined by commas.")
    ] = "bending,blocked_force",
    config: ConfigFile = None,
    overrides: Overrides = None,
    hide: Annotated[
        list[Any] | None,
        typer.Option(
            "--hide",
            metavar="KEY=VALUE",
            help="Like --set, but kept secret; repeatable.",
            callback=assigned_numbers,
        ),
    ] = None,
    nuisance: Annotated[
        list[str] | None,
        typer.Option(
            "--nuisance", metavar="EFFECT", help="Draw its values from its prior; repeatable."
        ),
    ] = None,
    noise: Noise = None,
    seed: Annotated[int, typer.Option(help="Seed of nuisances and noise.")] = 0,
    protocol: ProtocolOption = None,
    specimen: Specimen = None,
) -> None:
    """Write a synthetic measurement with hidden effects, nuisances and noise."""
    kinds = _measured(experiments)
    from dolfingrip.cli.commands import Setting, synthetic_measurement
    from dolfingrip.experiments.synthetic import check_noise

    check_noise(noises := dict(noise or ()))
    setting = Setting(config, dict(overrides or ()), protocol, specimen)
    for folder, posed in setting.poses(find(kinds[0]), out):
        truth = changed(posed, dict(hide or ()))
        synthetic_measurement(kinds, posed, truth, nuisance or (), noises, seed, folder, console())


def demo(
    out: Out = Path("out/demo"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    loop: Annotated[bool, typer.Option(help="Run the small design loop, too.")] = True,
) -> None:
    """Run both experiments on the reference finger and a small design loop, write a report."""
    from dolfingrip.cli.commands import run_demo

    resolved = configuration.load(config, dict(overrides or ()))
    results = run_demo(resolved, out, console())
    if loop and MPI.COMM_WORLD.size > 1:
        console().print("no design loop under mpirun: it starts processes of its own")
    elif loop:
        from dolfingrip.cli import small_loop

        small_loop.run(resolved, out / "loop")

    def work() -> None:
        from dolfingrip.cli.report_command import write_report

        with console().status("writing the report"):
            page = write_report([out], out / "report.html")
        console().print(f"report: {page}", soft_wrap=True)

    from dolfingrip.mechanics.model.domain import on_root

    on_root(MPI.COMM_WORLD, work)
    _exit(*results)


def _command(experiment: Experiment) -> Callable[..., None]:
    """The function of an experiment's subcommand; typer reads its signature."""

    def perform(
        out: Path,
        config: Path | None,
        overrides: list[Any] | None,
        render: str | None = None,
        colour_by: str = "displacement",
        protocol: Path | None = None,
        specimen: str | None = None,
        gradients: bool = False,
        parameters: str | None = None,
        **given: Any,
    ) -> None:
        if _instead(experiment, given, out):
            return
        from dolfingrip.cli.commands import Setting, run_experiment

        pressure = given.get(PRESSURE_OPTION.name)
        if protocol is not None and pressure is not None:
            raise ConfigError(
                f"{PRESSURE_OPTION.flag} {pressure:g}: allowed: without --protocol, which has its "
                "own pressures"
            )
        asked_for = {**dict(overrides or ()), **_settings(experiment, given)}
        setting = Setting(config, asked_for, protocol, specimen)
        keys = gradient_keys(gradients, parameters)
        drawn = render, colour_by
        _exit(*run_experiment(experiment, given, setting, out, drawn, console(), keys))

    parameters = _parameters(experiment)
    perform.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    perform.__annotations__ = {each.name: each.annotation for each in parameters}
    return perform


def _parameters(experiment: Experiment) -> list[Parameter]:
    """The options of an experiment's command, as the parameters of a function."""
    found: dict[str, tuple[Any, object]] = {
        "out": (Out, Path("out") / experiment.command),
        "config": (ConfigFile, None),
        "overrides": (Overrides, None),
        **{option.name: (_annotation(option), option.default) for option in experiment.options},
    }
    if experiment.drawable:
        found |= {"render": (Renders, None), "colour_by": (Colour, "displacement")}
    if experiment.gradients:
        found |= {"gradients": (Gradients, False), "parameters": (Parameters, None)}
    if experiment.protocol:
        found |= {"protocol": (ProtocolOption, None), "specimen": (Specimen, None)}
    return [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in found.items()
    ]


def _instead(experiment: Experiment, given: Mapping[str, Any], out: Path) -> bool:
    """Whether an option asked for another command in place of the experiment, which then ran.

    Raises:
        ConfigError: one line, where an option is given without the one that it needs.
    """
    on = {option.flag for option in experiment.options if given[option.name]}
    for option in experiment.options:
        if option.flag in on and option.needs and option.needs.split()[0] not in on:
            value = given[option.name]
            first = value[0] if isinstance(value, list) else f"{value:g}"
            raise ConfigError(f"{option.flag} {first}: allowed: with {option.needs}")
    for option in experiment.options:
        if option.command and option.flag in on:
            module = importlib.import_module(f"dolfingrip.cli.{option.command}_command")
            module.perform(given, out)
            return True
    return False


def _annotation(option: Option) -> Any:
    """The annotation by which typer knows an option of one experiment."""
    kind: Any = option.type if option.default is not None else option.type | None
    return Annotated[kind, typer.Option(option.flag, help=option.help)]


def _settings(experiment: Experiment, given: Mapping[str, Any]) -> Change:
    """Return the change of the configuration that the experiment's own options ask for."""
    return {
        option.key: given[option.name]
        for option in experiment.options
        if option.key and given[option.name] is not None
    }


def _measured(text: str) -> list[str]:
    """The names in ``--experiments``; the format of measured data must have all of them.

    Raises:
        ConfigError: one line with the names that are allowed.
    """
    allowed = [name for name, experiment in EXPERIMENTS.items() if experiment.measured]
    by_command = {EXPERIMENTS[name].command: name for name in allowed}
    names = [by_command.get(name, name) for name in text.split(",")]
    for name in names:
        if name not in allowed:
            raise ConfigError(
                f"--experiments {name}: allowed: {', '.join(allowed)}, joined by commas"
            )
    return names


def _exit(*results: Result) -> None:
    """Exit with code 1 if a load path ended early; its results up to there are kept."""
    endings = [end for each in results for end in (each.failure, *each.second_runs.values())]
    if any(ending is not None for ending in endings):
        raise typer.Exit(1)

"""A subcommand for each experiment of the index, made from what the experiment tells of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Overrides, console
from dolfingrip.config import Config
from dolfingrip.experiments.description import Option
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.sections import protocol_file

if TYPE_CHECKING:
    from dolfingrip.experiments.result import Result

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


def register(app: typer.Typer) -> None:
    """Give ``app`` a subcommand for each experiment."""
    for experiment in EXPERIMENTS.values():
        app.command(experiment.command, help=experiment.summary())(command(experiment))


def command(experiment: Experiment) -> Callable[..., None]:
    """The function behind an experiment's subcommand; typer reads its signature."""

    def perform(
        out: Path,
        config: Path | None,
        overrides: list[str] | None,
        render: str | None = None,
        colour_by: str = "displacement",
        protocol: Path | None = None,
        **given: Any,
    ) -> None:
        from dolfingrip.cli.commands import run_experiment

        overrides = [*(overrides or ()), *_assignments(experiment, given)]
        chosen = experiment.asked(given)
        found = poses(experiment, config, overrides, out, protocol)
        end(
            *[
                run_experiment(
                    chosen, experiment.settings(each), folder, render, colour_by, console()
                )
                for folder, each in found
            ]
        )

    parameters = _parameters(experiment)
    perform.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    perform.__annotations__ = {each.name: each.annotation for each in parameters}
    return perform


def _parameters(experiment: Experiment) -> list[Parameter]:
    """The options of an experiment's command, as those of a function."""
    folder = Annotated[Path, typer.Option(help="Folder for results.")]
    found = {
        "out": (folder, Path("out") / experiment.command),
        "config": (ConfigFile, None),
        "overrides": (Overrides, None),
        **{option.name: (_annotation(option), option.default) for option in experiment.options},
    }
    if experiment.poses:
        found |= {"render": (Renders, None), "colour_by": (Colour, "displacement")}
    if experiment.protocol:
        found["protocol"] = (ProtocolOption, None)
    return [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in found.items()
    ]


def _annotation(option: Option) -> Any:
    kind: Any = option.type if option.default is not None else option.type | None
    return Annotated[kind, typer.Option(option.flag, help=option.help)]


def _assignments(experiment: Experiment, given: Mapping[str, Any]) -> list[str]:
    """What the options of an experiment's own set in the configuration, as with ``--set``."""
    return [
        f"{option.key}={given[option.name]}"
        for option in experiment.options
        if option.key and given[option.name] is not None
    ]


def poses(
    experiment: Experiment,
    config: Path | None,
    overrides: list[str] | None,
    out: Path,
    protocol: Path | None,
) -> list[tuple[Path, Config]]:
    """Folder and configuration of each set-up that the protocol asks for."""
    if protocol is None:
        return [(out, configuration.load(config, overrides or ()))]
    table, found = protocol_file.read(protocol, experiment.name, experiment.led)
    settings = [
        (out / pose.name, configuration.load(config, [*(overrides or ()), *pose.set]))
        for pose in found
    ] or [(out, configuration.load(config, overrides or ()))]
    return [(folder, resolved.changed(protocol=table)) for folder, resolved in settings]


def end(*results: Result) -> None:
    """Exit code 1 where a load path ended early, its results up to there being kept."""
    if any(result.failure is not None for result in results):
        raise typer.Exit(1)

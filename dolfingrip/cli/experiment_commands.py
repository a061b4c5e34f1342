"""The commands of the experiments, ``synthetic`` and ``demo``: they run, plot, draw and print."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, DISPLACEMENT, FORCE, NOMINAL_STRESS, PRESSURE, TIME, VOLUME
from dolfingrip.cli import progress
from dolfingrip.cli.console import Screen, check_writable, console, gradient_keys
from dolfingrip.cli.settings import RunSettings, SyntheticSettings
from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError, changed
from dolfingrip.experiments import pressures_kPa, synthetic
from dolfingrip.experiments.chart import over
from dolfingrip.experiments.derivatives import bands
from dolfingrip.experiments.derivatives.sensitivities import choices, chosen
from dolfingrip.experiments.experiment import PRESSURE_OPTION, SUCTION_OPTION, Experiment
from dolfingrip.experiments.idle import idle
from dolfingrip.experiments.index import EXPERIMENTS, find
from dolfingrip.experiments.loop import follow
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.synthetic import check_noise
from dolfingrip.mechanics.model.compilation import Tell
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.report.drawers import WantedPictures, drawer
from dolfingrip.report.table import tabulate
from dolfingrip.sections import protocol_file, tables
from dolfingrip.sections.supply import AirLine, refuse_supply
from dolfingrip.sections.tables import assignments

SAID = (PRESSURE, ANGLE, DISPLACEMENT, NOMINAL_STRESS, FORCE)
"""Channels whose readings a video says, where the experiment has them."""

DEMO = ("bending", "blocked_force")
DEMO_RENDERS_KPA = (0.0, 100.0, 200.0)


def run_experiment(request: Request, args: RunSettings, screen: Screen) -> Result:
    """Run one experiment, print its table, plot its curve and draw deformed shapes.

    Args:
        request: experiment, configuration and folder for results.
        args: pressures that are drawn, and colours.
        screen: where the output is printed.

    Raises:
        ConfigError: on every rank, one line, before anything is computed.
    """
    experiment, config, out = request.experiment, request.config, request.fields
    assert out is not None
    wanted = _pressures(args.render, config)
    check_writable(out)
    warn(experiment, config, screen, args.overrides)
    keys = request.gradients
    if request.bands is not None:
        keys = bands.Bands.of(experiment, config, request.bands).keys(keys)
    if keys is not None:
        chosen(config, request.gradients)  # a bad key raises before anything is computed
        for choice in choices(config, request.gradients):
            screen.say(
                f"{choice.key}: a choice of the model, which has no derivative. A second run is "
                f"made {'without' if choice.made else 'with'} it; sensitivity.csv has the "
                f'difference of the two as "{choice.label}"'
            )
    result = _run(request, screen)
    _pictures(experiment, result, out, wanted, wanted_pictures(args), screen)
    if MPI.COMM_WORLD.rank == 0:
        _print(experiment, result, out, screen)
    return result


def run_demo(config: Config, out: Path, console: Screen) -> list[Result]:
    """Run both experiments, draw the pictures of each as soon as it ends, print one table."""
    shown = [find(name) for name in DEMO]
    warn(shown[0], config, console)
    wanted = [p for p in DEMO_RENDERS_KPA if p in pressures_kPa(config)]
    results = []
    for experiment in shown:
        result = _run(Request.of(experiment, config, fields=out / experiment.name), console)
        results.append(result)
        pictures = _pictures(
            experiment, result, out / experiment.name, wanted, WantedPictures(video=False), console
        )
        for file in pictures:
            console.say(f"wrote {file}")
    if MPI.COMM_WORLD.rank == 0:
        parts = [
            (experiment.table, result.columns())
            for experiment, result in zip(shown, results, strict=True)
        ]
        if all(result.rows for result in results):
            console.print(tabulate(*parts, title="Reference finger"))
        for experiment, result in zip(shown, results, strict=True):
            _print_remarks(experiment, result, console)
        console.say(f"pictures, tables and ParaView fields: {out}")
    return results


def wanted_pictures(args: RunSettings) -> WantedPictures:
    """How pictures are asked for; the film of a grasp needs no asking.

    Args:
        args: settings of the command.
    """
    video = args.experiment.pictures != "finger" if args.video is None else args.video
    turn_deg = WantedPictures().turn_deg if args.video_turn is None else args.video_turn
    cut = args.cut or args.colour_by == "pressure"  # no wall of a chamber is seen from outside
    return WantedPictures(args.colour_by, cut, video, args.video_length, turn_deg)


def _pressures(wanted: Sequence[float], config: Config) -> Sequence[float]:
    """Check that the pressures of ``--render`` are among those of the run."""
    if not wanted:
        return wanted
    readings_kPa = pressures_kPa(config)
    if not readings_kPa:
        raise ConfigError('--render: allowed: with experiment.control = "pressure" only')
    for pressure in wanted:
        if not np.isclose(readings_kPa, pressure).any():
            allowed = ", ".join(f"{p:g}" for p in dict.fromkeys(readings_kPa))
            raise ConfigError(f"--render {pressure:g}: allowed: {allowed} (kPa)")
    return wanted


def warn(
    experiment: Experiment, config: Config, console: Screen, overrides: Change = NO_CHANGE
) -> None:
    """Print what is doubtful about a configuration, and which of its overrides do nothing."""
    for note in [*idle(experiment, config, overrides), *experiment.notes(config)]:
        console.say(f"warning: {note}", style="yellow")


def _run(request: Request, console: Screen) -> Result:
    runs = 1 + len(choices(request.config, request.gradients)) + request.mesh_check
    with _bar(request.experiment.title, runs * [request], console) as (advance, tell):
        return follow(request, MPI.COMM_WORLD, advance, tell)


@contextmanager
def _bar(
    title: str, requests: Sequence[Request], console: Screen
) -> Iterator[tuple[Callable[[Row], None], Tell]]:
    """Yield what to call with each row of the experiments, and with a line about an iteration."""
    controls = {request.experiment.name: request.experiment.control for request in requests}
    efforts = [
        effort for request in requests for effort in request.experiment.efforts(request.config)
    ]
    total = len(efforts)
    rows, reached = 0, ""
    first = "mesh and forms"
    what = f"{title.lower()} readings"
    forecast = progress.Forecast(efforts)
    with progress.shown(console, what, total=total, note=first, pace=forecast) as show:

        def advance(row: Row) -> None:
            nonlocal rows, reached
            rows += 1
            control = controls[row["experiment"]]
            # nobody knows the stops after a change to volume control before it
            reached = f"{row[control.name]:zg} {control.symbol}"
            show(rows, max(rows, total), reached)

        def tell(line: str) -> None:
            show(rows, max(rows, total), ", ".join(filter(None, (reached, line))) or first)

        yield advance, tell


def _pictures(
    experiment: Experiment,
    result: Result,
    out: Path,
    wanted: Sequence[float],
    look: WantedPictures,
    console: Screen,
) -> list[Path]:
    """Plot the curve, draw the finger at the pressures reached, return the files (on rank 0)."""

    def work() -> list[Path]:
        if not result.rows:
            return []
        with console.status("plotting and rendering"):
            columns = result.columns()
            from dolfingrip.charts import picture

            curve_file = picture.write([result.chart()], out / "curve.png", picture.Look(across=1))
            if (special_drawer := drawer(experiment.pictures)) is not None:
                return [curve_file, *special_drawer.draw(out, result.config, columns, look)]
            files = [curve_file]
            reached = [p for p in wanted if np.isclose(result.column(PRESSURE.name), p).any()]
            if not reached and not look.video:
                return files
            from dolfingrip.report import render
            from dolfingrip.report.beside import Beside

            others = Beside.of_run(result.config, result.plate)
            kind: dict[str, Any] = {"colour_by": look.colour_by or "displacement", "beside": others}
            if look.cut or "finger" not in experiment.parts:  # a coupon is whole as it is meshed
                kind["shown"] = "half"
            elif others.curves:  # in the cut, as it is the back's middle that is compared
                kind["shown"] = "section"
            if reached:
                drawn = render.draw(out / "fields.pvd", reached, **kind)
                files += drawn.save_each(out)
                files += [drawn.save_strip(out / "strip.png")] if len(reached) > 1 else []
            if look.video:
                in_time = [TIME] if over(experiment, columns) == TIME else []
                said = [quantity for quantity in (*in_time, *SAID) if quantity.name in columns]
                turn_deg = 0.0 if kind.get("shown") == "section" else look.turn_deg
                kind |= {"result": columns, "seconds": look.seconds, "turn_deg": turn_deg}
                moving = render.draw_video(out / "fields.pvd", said, **kind)
                files += moving.save_video(out / "video")
            return files

    return on_root(MPI.COMM_WORLD, work) or []


def _print(experiment: Experiment, result: Result, out: Path, console: Screen) -> None:
    if result.rows:
        check = result.facts.mesh_check
        main = experiment.plot.curves[0].column
        errors = {main: check.errors[main]} if check and main in check.errors else {}
        shown = experiment.table, result.columns()
        console.print(tabulate(shown, title=experiment.title, errors=errors))
        if check is not None and main not in check.errors:
            console.say(f"error of the mesh: cannot tell: {check.reason(main)}", style="yellow")
    _print_remarks(experiment, result, console)
    console.say(f"results: {out}")


def _print_remarks(experiment: Experiment, result: Result, console: Screen) -> None:
    for remark in [*experiment.remarks(result), *bands.band_sentences(experiment, result)]:
        console.say(remark)
    for key, ending in result.second_runs.items():
        if ending is not None:
            console.say(
                f"{experiment.title}, the second run for {key} {ending.sentence()}", style="red"
            )
    if result.failure is not None:
        console.say(f"{experiment.title} {result.failure.sentence()}", style="red")


def synthetic_measurement(args: SyntheticSettings) -> None:
    """Write a synthetic measurement with hidden effects, nuisances and noise."""
    kinds = _measured(args.experiments)
    check_noise(args.noise)
    screen, failures = console(), []
    for out, config in _poses(find(kinds[0]), args, args.overrides):
        check_writable(out)
        requests = [Request.of(kind, config) for kind in kinds]
        with _bar("Synthetic measurement", requests, screen) as (advance, tell):
            measurement = synthetic.measure(
                kinds,
                config,
                hidden=changed(config, args.hide),
                nuisances=args.nuisance,
                noise={**synthetic.NOISE, **args.noise},
                seed=args.seed,
                progress=advance,
                tell=tell,
            )
        synthetic.write(measurement, out)
        failures += measurement.failures
        for failure in measurement.failures:
            screen.say(failure.sentence(), style="red")
        screen.say(
            f"{len(measurement.rows)} readings: {out / 'measured.csv'} and .toml; "
            f"what is behind them: {out / 'truth.toml'}"
        )
    if failures:
        raise typer.Exit(1)


def perform(args: RunSettings) -> None:
    """Run an experiment for each set-up that is asked for."""
    experiment, given = args.experiment, args.own()
    _check_needs(experiment, given)
    for option in (PRESSURE_OPTION, SUCTION_OPTION):
        pressure = given.get(option.name)
        if args.protocol is not None and pressure is not None:
            raise ConfigError(
                f"{option.flag} {pressure:g}: allowed: without --protocol, which has its own "
                "pressures"
            )
    changes = {
        option.key: given[option.name]
        for option in experiment.options
        if option.key and given[option.name] is not None
    }
    poses = _poses(experiment, args, {**args.overrides, **changes})
    keys, kind = gradient_keys(args.gradients, args.parameters), experiment.with_options(given)
    if kind is not experiment:  # which has settings of its own
        poses = [(folder, experiment.settings(config)) for folder, config in poses]
    if args.uncertain and not args.bands:
        key = next(iter(args.uncertain))
        raise ConfigError(f"--uncertain {key}: allowed: with --bands")
    if args.colour_by == "pressure" and not {"finger", "gripper"} & set(experiment.parts):
        raise ConfigError("--colour-by pressure: allowed: for fingers, whose chambers have one")
    of_film = {"--video-length": args.video_length, "--video-turn": args.video_turn}
    for flag, value in of_film.items():
        if value is not None and not wanted_pictures(args).video:
            raise ConfigError(f"{flag} {value:g}: allowed: with --video")
    wanted = {
        "mesh_check": args.mesh_check,
        "bands": args.uncertain if args.bands else None,
    }
    requests = [Request.of(kind, config, keys, fields=folder, **wanted) for folder, config in poses]
    if not AirLine.felt_on(experiment.parts):
        refuse_supply(requests[0].config.supply)
    screen = console()
    exit_early(*[run_experiment(request, args, screen) for request in requests])


def _check_needs(experiment: Experiment, given: Mapping[str, Any]) -> None:
    """Raise where an option is given without the one that it needs."""
    on = {option.flag for option in experiment.options if given[option.name]}
    for option in experiment.options:
        if option.flag in on and option.needs and option.needs.split()[0] not in on:
            value = given[option.name]
            first = value[0] if isinstance(value, tuple) else f"{value:g}"
            raise ConfigError(f"{option.flag} {first}: allowed: with {option.needs}")


def _measured(given: Sequence[str]) -> list[str]:
    """The names in ``--experiments``; the format of measured data must have all of them.

    Raises:
        ConfigError: one line with the names that are allowed.
    """
    allowed = [name for name, experiment in EXPERIMENTS.items() if experiment.measured]
    by_command = {EXPERIMENTS[name].command: name for name in allowed}
    names = [by_command.get(name, name) for name in given]
    for name in names:
        if name not in allowed:
            raise ConfigError(
                f"--experiments {name}: allowed: {', '.join(allowed)}, joined by commas"
            )
    return names


def _poses(
    experiment: Experiment, args: RunSettings | SyntheticSettings, changes: Change
) -> list[tuple[Path, Config]]:
    """Folder and configuration of each set-up that the protocol asks for."""
    if args.protocol is None:
        if args.specimen is not None:
            raise ConfigError(f"--specimen {args.specimen}: allowed: with --protocol FILE.csv")
        return [(args.out, configuration.load(args.config, changes))]
    experiment_keys = tables.read(args.config).get("experiment", {}) if args.config else {}

    def setting(key: str) -> Any:
        return changes.get(f"experiment.{key}", experiment_keys.get(key))

    by_volume = experiment.control is PRESSURE and setting("control") == "volume"
    table, poses = protocol_file.read(
        args.protocol,
        experiment.name,
        VOLUME.name if by_volume else experiment.control.name,
        args.specimen,
        even=bool(setting("dynamic")),
    )
    settings: list[tuple[Path, Change]] = [
        (args.out / pose.name, {**changes, **assignments(pose.set)}) for pose in poses
    ] or [(args.out, changes)]
    readings = {protocol_file.key(column): values for column, values in table.items()}
    return [
        (folder, configuration.load(args.config, {**change, **readings}))
        for folder, change in settings
    ]


def exit_early(*results: Result) -> None:
    """Exit with code 1 if a load path ended early; its results up to there are kept."""
    endings = [end for result in results for end in (result.failure, *result.second_runs.values())]
    if any(ending is not None for ending in endings):
        raise typer.Exit(1)

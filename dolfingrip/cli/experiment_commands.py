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
from dolfingrip.channels import ANGLE, DISPLACEMENT, FORCE, NOMINAL_STRESS, PRESSURE
from dolfingrip.cli import progress
from dolfingrip.cli.console import Screen, check_writable, console, gradient_keys
from dolfingrip.cli.settings import RunSettings, SyntheticSettings
from dolfingrip.config import Change, Config, ConfigError, changed
from dolfingrip.experiments import pressures_kPa, synthetic
from dolfingrip.experiments.derivatives import bands
from dolfingrip.experiments.derivatives.sensitivities import choices, chosen
from dolfingrip.experiments.experiment import PRESSURE_OPTION, SUCTION_OPTION, Experiment
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
from dolfingrip.sections.tables import assignments

SAID = (PRESSURE, ANGLE, DISPLACEMENT, NOMINAL_STRESS, FORCE)
"""Channels whose readings a video says, where the experiment has them."""

DEMO = ("bending", "blocked_force")
DEMO_RENDERS_KPA = (0.0, 100.0, 200.0)


def run_experiment(request: Request, asked: RunSettings, screen: Screen) -> Result:
    """Run one experiment, print its table, plot its curve and draw deformed shapes.

    Args:
        request: experiment, configuration and folder for results.
        asked: pressures that are drawn, and colours.
        screen: where the output is printed.

    Raises:
        ConfigError: on every rank, one line, before anything is computed.
    """
    experiment, config, out = request.experiment, request.config, request.fields
    assert out is not None
    wanted = _pressures(asked.render, config)
    check_writable(out)
    warn(experiment, config, screen)
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
    _pictures(experiment, result, out, wanted, wanted_pictures(asked), screen)
    if MPI.COMM_WORLD.rank == 0:
        _print(experiment, result, out, screen)
    return result


def run_demo(config: Config, out: Path, console: Screen) -> list[Result]:
    """Run both experiments, draw the pictures of each as soon as it ends, print one table."""
    check_writable(out)
    shown = [find(name) for name in DEMO]
    warn(shown[0], config, console)
    wanted = [p for p in DEMO_RENDERS_KPA if p in pressures_kPa(config)]
    results = []
    for each in shown:
        result = _run(Request.of(each, config, fields=out / each.name), console)
        results.append(result)
        pictures = _pictures(
            each, result, out / each.name, wanted, WantedPictures(video=False), console
        )
        for file in pictures:
            console.say(f"wrote {file}")
    if MPI.COMM_WORLD.rank == 0:
        parts = [
            (each.table, result.columns()) for each, result in zip(shown, results, strict=True)
        ]
        if all(result.rows for result in results):
            console.print(tabulate(*parts, title="Reference finger"))
        for each, result in zip(shown, results, strict=True):
            _print_remarks(each, result, console)
        console.say(f"pictures, tables and ParaView fields: {out}")
    return results


def wanted_pictures(asked: RunSettings) -> WantedPictures:
    """How pictures are asked for; the film of a grasp needs no asking.

    Args:
        asked: settings of the command.
    """
    video = asked.experiment.pictures != "finger" if asked.video is None else asked.video
    turn_deg = WantedPictures().turn_deg if asked.video_turn is None else asked.video_turn
    cut = asked.cut or asked.colour_by == "pressure"  # no wall of a chamber is seen from outside
    return WantedPictures(asked.colour_by, cut, video, asked.video_length, turn_deg)


def _pressures(wanted: Sequence[float], config: Config) -> Sequence[float]:
    """Check that the pressures of ``--render`` are among those of the run."""
    if not wanted:
        return wanted
    known = pressures_kPa(config)
    if not known:
        raise ConfigError('--render: allowed: with experiment.control = "pressure" only')
    for pressure in wanted:
        if not np.isclose(known, pressure).any():
            allowed = ", ".join(f"{p:g}" for p in dict.fromkeys(known))
            raise ConfigError(f"--render {pressure:g}: allowed: {allowed} (kPa)")
    return wanted


def warn(experiment: Experiment, config: Config, console: Screen) -> None:
    """Print what is doubtful about a configuration."""
    for note in experiment.notes(config):
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
    controls = {each.experiment.name: each.experiment.control for each in requests}
    efforts = [effort for each in requests for effort in each.experiment.efforts(each.config)]
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
            if (own := drawer(experiment.pictures)) is not None:
                return [curve_file, *own.draw(out, result.config, columns, look)]
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
                said = [each for each in SAID if each.name in columns]
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


def synthetic_measurement(asked: SyntheticSettings) -> None:
    """Write a synthetic measurement with hidden effects, nuisances and noise."""
    kinds = _measured(asked.experiments)
    check_noise(asked.noise)
    screen = console()
    for out, config in _poses(find(kinds[0]), asked, asked.overrides):
        check_writable(out)
        requests = [Request.of(kind, config) for kind in kinds]
        with _bar("Synthetic measurement", requests, screen) as (advance, tell):
            found = synthetic.measure(
                kinds,
                config,
                hidden=changed(config, asked.hide),
                nuisances=asked.nuisance,
                noise={**synthetic.NOISE, **asked.noise},
                seed=asked.seed,
                progress=advance,
                tell=tell,
            )
        synthetic.write(found, out)
        for failure in found.failures:
            screen.say(failure.sentence(), style="red")
        screen.say(
            f"{len(found.rows)} readings: {out / 'measured.csv'} and .toml; "
            f"what is behind them: {out / 'truth.toml'}"
        )


def perform(asked: RunSettings) -> None:
    """Run an experiment for each set-up that is asked for."""
    experiment, given = asked.experiment, asked.own()
    _check_needs(experiment, given)
    for option in (PRESSURE_OPTION, SUCTION_OPTION):
        pressure = given.get(option.name)
        if asked.protocol is not None and pressure is not None:
            raise ConfigError(
                f"{option.flag} {pressure:g}: allowed: without --protocol, which has its own "
                "pressures"
            )
    own = {
        option.key: given[option.name]
        for option in experiment.options
        if option.key and given[option.name] is not None
    }
    poses = _poses(experiment, asked, {**asked.overrides, **own})
    keys, kind = gradient_keys(asked.gradients, asked.parameters), experiment.with_options(given)
    if kind is not experiment:  # which has settings of its own
        poses = [(folder, experiment.settings(config)) for folder, config in poses]
    if asked.uncertain and not asked.bands:
        key = next(iter(asked.uncertain))
        raise ConfigError(f"--uncertain {key}: allowed: with --bands")
    if asked.colour_by == "pressure" and not {"finger", "gripper"} & set(experiment.parts):
        raise ConfigError("--colour-by pressure: allowed: for fingers, whose chambers have one")
    of_film = {"--video-length": asked.video_length, "--video-turn": asked.video_turn}
    for flag, value in of_film.items():
        if value is not None and not wanted_pictures(asked).video:
            raise ConfigError(f"{flag} {value:g}: allowed: with --video")
    wanted = {
        "mesh_check": asked.mesh_check,
        "bands": asked.uncertain if asked.bands else None,
    }
    requests = [Request.of(kind, config, keys, fields=folder, **wanted) for folder, config in poses]
    screen = console()
    exit_early(*[run_experiment(request, asked, screen) for request in requests])


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
    experiment: Experiment, asked: RunSettings | SyntheticSettings, changes: Change
) -> list[tuple[Path, Config]]:
    """Folder and configuration of each set-up that the protocol asks for."""
    if asked.protocol is None:
        if asked.specimen is not None:
            raise ConfigError(f"--specimen {asked.specimen}: allowed: with --protocol FILE.csv")
        return [(asked.out, configuration.load(asked.config, changes))]
    told = tables.read(asked.config).get("experiment", {}) if asked.config else {}
    table, poses = protocol_file.read(
        asked.protocol,
        experiment.name,
        experiment.control.name,
        asked.specimen,
        even=changes.get("experiment.dynamic", told.get("dynamic", False)),
    )
    settings: list[tuple[Path, Change]] = [
        (asked.out / pose.name, {**changes, **assignments(pose.set)}) for pose in poses
    ] or [(asked.out, changes)]
    readings = {protocol_file.key(column): values for column, values in table.items()}
    return [
        (folder, configuration.load(asked.config, {**change, **readings}))
        for folder, change in settings
    ]


def exit_early(*results: Result) -> None:
    """Exit with code 1 if a load path ended early; its results up to there are kept."""
    endings = [end for each in results for end in (each.failure, *each.second_runs.values())]
    if any(ending is not None for ending in endings):
        raise typer.Exit(1)

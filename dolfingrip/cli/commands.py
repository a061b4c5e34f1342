"""The work of the commands: they run, plot, draw and print."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import cast, get_args

import numpy as np
from mpi4py import MPI
from rich.console import Console

from dolfingrip.channels import PRESSURE
from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.options import check_writable
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import pressures_kPa, run, synthetic
from dolfingrip.experiments.derivatives.choices import choices
from dolfingrip.experiments.derivatives.sensitivities import chosen
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import find
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results.readings import Row
from dolfingrip.mechanics.model.compilation import Tell
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.report import render
from dolfingrip.report.table import tabulate

DEMO = ("bending", "blocked_force")
DEMO_RENDERS_KPA = (0.0, 100.0, 200.0)


def run_experiment(
    experiment: Experiment,
    config: Config,
    out: Path,
    renders: str | None,
    colour_by: str,
    console: Console,
    gradients: Sequence[str] | None = None,
) -> Result:
    """Run one experiment, print its table, plot its curve and draw deformed shapes.

    Args:
        experiment: experiment to run.
        config: configuration of the run.
        out: folder for results.
        renders: pressures to draw (kPa), joined by commas.
        colour_by: ``displacement`` or ``stretch``.
        console: where the output is printed.
        gradients: keys of parameters that readings are derived by; []: all parameters; None: no
            derivatives.

    Raises:
        ConfigError: on every rank, one line, before anything is computed.
    """
    wanted = _pressures(renders, config)
    quantity = _quantity(colour_by)
    check_writable(out)
    warn(experiment, config, console)
    if gradients is not None:
        # a bad key raises before anything is computed
        chosen(experiment.settings(config), gradients)
        for choice in choices(experiment.settings(config), gradients):
            console.print(
                f"{choice.key}: a choice of the model, which has no derivative. A second run is "
                f"made {'without' if choice.made else 'with'} it; sensitivity.csv has the "
                f'difference of the two as "{choice.label}"',
                soft_wrap=True,
            )
    result = _run(experiment, config, out, console, gradients)
    _pictures(experiment, result, out, wanted, quantity, console)
    if MPI.COMM_WORLD.rank == 0:
        _print(experiment, result, out, console)
    return result


def synthetic_measurement(
    kinds: Sequence[str],
    config: Config,
    truth: Config,
    nuisances: Sequence[str],
    noise: Sequence[str],
    seed: int,
    out: Path,
    console: Console,
) -> None:
    """Simulate a data set, add noise to it and write it.

    Args:
        kinds: names of the experiments.
        config: set-up that the data set tells about itself.
        truth: set-up that is simulated.
        nuisances: effects whose values are drawn from their priors.
        noise: standard deviations of noise, ``COLUMN=VALUE``.
        seed: seed of the nuisances' draws and of the noise.
        out: folder for the data set.
        console: where the output is printed.

    Raises:
        ConfigError: one line naming the option, its value and what is allowed.
    """
    channels = synthetic.noise_from(noise)
    check_writable(out)
    with _bar("Synthetic measurement", [find(kind) for kind in kinds], config, console) as (
        advance,
        tell,
    ):
        found = synthetic.measure(
            kinds,
            config,
            hidden=truth,
            nuisances=nuisances,
            noise=channels,
            seed=seed,
            progress=advance,
            tell=tell,
        )
    synthetic.write(found, out)
    for failure in found.failures:
        console.print(failure.sentence(), style="red", soft_wrap=True)
    console.print(
        f"{len(found.rows)} readings: {out / 'measured.csv'} and .toml; "
        f"what is behind them: {out / 'truth.toml'}",
        soft_wrap=True,
    )


def run_demo(config: Config, out: Path, console: Console) -> list[Result]:
    """Run both experiments, draw the pictures of each as soon as it ends, print one table."""
    check_writable(out)
    shown = [find(name) for name in DEMO]
    warn(shown[0], config, console)
    wanted = [p for p in DEMO_RENDERS_KPA if p in pressures_kPa(config)]
    results = []
    for each in shown:
        result = _run(each, config, out / each.name, console)
        results.append(result)
        pictures = _pictures(each, result, out / each.name, wanted, "displacement", console)
        for file in pictures:
            console.print(f"wrote {file}", soft_wrap=True)
    if MPI.COMM_WORLD.rank == 0:
        parts = [
            (each.table, result.columns()) for each, result in zip(shown, results, strict=True)
        ]
        if all(result.rows for result in results):
            console.print(tabulate(*parts, title="Reference finger"))
        for each, result in zip(shown, results, strict=True):
            _print_remarks(each, result, console)
        console.print(f"pictures, tables and ParaView fields: {out}", soft_wrap=True)
    return results


def _quantity(text: str) -> render.Quantity:
    """The quantity that ``--colour-by`` asks for."""
    for quantity in get_args(render.Quantity):
        if text == quantity:
            return cast(render.Quantity, quantity)
    allowed = ", ".join(get_args(render.Quantity))
    raise ConfigError(f"--colour-by {text}: allowed: {allowed}")


def _pressures(text: str | None, config: Config) -> list[float]:
    """Pressures of ``--render``, which must be among the pressures of the run."""
    if not text:
        return []
    known = pressures_kPa(config)
    if not known:
        raise ConfigError('--render: allowed: with experiment.control = "pressure" only')
    try:
        wanted = [float(part) for part in text.split(",")]
    except ValueError:
        raise ConfigError(f"--render {text}: allowed: pressures in kPa, as in 0,100,200") from None
    for pressure in wanted:
        if not np.isclose(known, pressure).any():
            allowed = ", ".join(f"{p:g}" for p in dict.fromkeys(known))
            raise ConfigError(f"--render {pressure:g}: allowed: {allowed} (kPa)")
    return wanted


def warn(experiment: Experiment, config: Config, console: Console) -> None:
    """Print what is doubtful about a configuration."""
    for note in experiment.notes(config):
        console.print(f"warning: {note}", style="yellow", soft_wrap=True)


def _run(
    experiment: Experiment,
    config: Config,
    out: Path,
    console: Console,
    gradients: Sequence[str] | None = None,
) -> Result:
    runs = 1 + len(choices(experiment.settings(config), gradients))
    with _bar(experiment.title, runs * [experiment], config, console) as (advance, tell):
        return run(experiment, config, out=out, progress=advance, gradients=gradients, tell=tell)


@contextmanager
def _bar(
    title: str, experiments: Sequence[Experiment], config: Config, console: Console
) -> Iterator[tuple[Callable[[Row], None], Tell]]:
    """Yield what to call with each row of the experiments, and with a line about an iteration."""
    controls = {each.name: each.control for each in experiments}
    efforts = [effort for each in experiments for effort in each.efforts(each.settings(config))]
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
    wanted: list[float],
    colour_by: render.Quantity,
    console: Console,
) -> list[Path]:
    """Plot the curve, draw the finger at the pressures reached, return the files (on rank 0)."""

    def work() -> list[Path]:
        if not result.rows:
            return []
        with console.status("plotting and rendering"):
            columns = result.columns()
            curve_file = picture.write([result.chart()], out / "curve.png", picture.Look(across=1))
            if experiment.pictures != "finger":
                module = importlib.import_module(f"dolfingrip.report.{experiment.pictures}")
                return [curve_file, *module.draw(out, result.config, columns)]
            reached = [p for p in wanted if np.isclose(result.column(PRESSURE.name), p).any()]
            if not reached:
                return [curve_file]
            drawn = render.draw(
                out / "fields.pvd", reached, colour_by=colour_by, plate=_plate(result)
            )
            each = drawn.save_each(out)
            strip = [drawn.save_strip(out / "strip.png")] if len(reached) > 1 else []
            return [curve_file, *each, *strip]

    return on_root(MPI.COMM_WORLD, work) or []


def _plate(result: Result) -> render.Plate | None:
    """The force sensor for the picture; None if there is none."""
    if result.plate is None:
        return None
    return render.Plate(
        point_mm=result.plate.point_mm,
        normal=result.plate.normal,
        contact_length_mm=result.config.plate.contact_length_mm,
    )


def _print(experiment: Experiment, result: Result, out: Path, console: Console) -> None:
    if result.rows:
        console.print(tabulate((experiment.table, result.columns()), title=experiment.title))
    _print_remarks(experiment, result, console)
    console.print(f"results: {out}", soft_wrap=True)


def _print_remarks(experiment: Experiment, result: Result, console: Console) -> None:
    for remark in experiment.remarks(result):
        console.print(remark, soft_wrap=True)
    for key, ending in result.second_runs.items():
        if ending is not None:
            console.print(
                f"{experiment.title}, the second run for {key} {ending.sentence()}",
                style="red",
                soft_wrap=True,
            )
    if result.failure is not None:
        console.print(
            f"{experiment.title} {result.failure.sentence()}", style="red", soft_wrap=True
        )

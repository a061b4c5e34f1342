"""The work of the commands: they run, plot, draw and print."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, get_args

import numpy as np
from mpi4py import MPI
from rich.console import Console

from dolfingrip import config as configuration
from dolfingrip.channels import PRESSURE
from dolfingrip.cli import progress
from dolfingrip.cli.options import check_writable
from dolfingrip.config import Change, Config, ConfigError
from dolfingrip.experiments import pressures_kPa, synthetic
from dolfingrip.experiments.derivatives.choices import choices
from dolfingrip.experiments.derivatives.sensitivities import chosen
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import find
from dolfingrip.experiments.loop import follow
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results.readings import Row
from dolfingrip.mechanics.model.compilation import Tell
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.report import Quantity
from dolfingrip.report.table import tabulate
from dolfingrip.sections import protocol_file
from dolfingrip.sections.tables import assignments

if TYPE_CHECKING:
    from dolfingrip.report.scene import Plate

DEMO = ("bending", "blocked_force")
DEMO_RENDERS_KPA = (0.0, 100.0, 200.0)


@dataclass(frozen=True, slots=True)
class Setting:
    """Where an experiment's configuration comes from.

    Attributes:
        config: TOML file, or the ``run.json`` of an earlier run; None: the reference finger.
        overrides: values by key on top of it.
        protocol: TOML of ramps and waits, or a measurement's CSV; None: the experiment's own.
        specimen: in that CSV; None: the only one.
    """

    config: Path | None
    overrides: Change
    protocol: Path | None = None
    specimen: str | None = None

    def poses(self, experiment: Experiment, out: Path) -> list[tuple[Path, Config]]:
        """Return folder and configuration of each set-up that the protocol asks for.

        Args:
            experiment: that is run.
            out: folder for results.

        Returns:
            One set-up, or those that the protocol names.

        Raises:
            ConfigError: one line about a key, the protocol or the specimen.
        """
        if self.protocol is None:
            if self.specimen is not None:
                raise ConfigError(f"--specimen {self.specimen}: allowed: with --protocol FILE.csv")
            return [(out, configuration.load(self.config, self.overrides))]
        table, poses = protocol_file.read(
            self.protocol, experiment.name, experiment.control.name, self.specimen
        )
        settings = [
            (
                out / pose.name,
                configuration.load(self.config, {**self.overrides, **assignments(pose.set)}),
            )
            for pose in poses
        ] or [(out, configuration.load(self.config, self.overrides))]
        return [(folder, resolved.changed(protocol=table)) for folder, resolved in settings]


def run_experiment(
    experiment: Experiment,
    given: Mapping[str, Any],
    setting: Setting,
    out: Path,
    drawn: tuple[str | None, str],
    console: Console,
    gradients: Sequence[str] | None = None,
) -> list[Result]:
    """Run one experiment in each of its set-ups; print tables, plot curves, draw shapes.

    Args:
        experiment: of the command.
        given: values of its own options, by name.
        setting: where the configuration comes from.
        out: folder for results.
        drawn: pressures to draw (kPa), joined by commas, and ``displacement`` or ``stretch``.
        console: where the output is printed.
        gradients: keys of parameters that readings are derived by; []: all parameters; None: no
            derivatives.

    Returns:
        The result of each set-up.

    Raises:
        ConfigError: on every rank, one line, before anything is computed.
    """
    asked = experiment.with_options(given)
    poses = setting.poses(experiment, out)
    if asked is not experiment:  # which has settings of its own
        poses = [(folder, experiment.settings(posed)) for folder, posed in poses]
    requests = [Request.of(asked, posed, gradients, fields=folder) for folder, posed in poses]
    return [_shown(request, drawn, console) for request in requests]


def _shown(request: Request, drawn: tuple[str | None, str], console: Console) -> Result:
    """Run one set-up, print its table, plot its curve and draw deformed shapes."""
    experiment, config, out = request.experiment, request.config, request.fields
    assert out is not None
    wanted, quantity = _pressures(drawn[0], config), _quantity(drawn[1])
    check_writable(out)
    warn(experiment, config, console)
    if request.gradients is not None:
        chosen(config, request.gradients)  # a bad key raises before anything is computed
        for choice in choices(config, request.gradients):
            console.print(
                f"{choice.key}: a choice of the model, which has no derivative. A second run is "
                f"made {'without' if choice.made else 'with'} it; sensitivity.csv has the "
                f'difference of the two as "{choice.label}"',
                soft_wrap=True,
            )
    result = _run(request, console)
    _pictures(experiment, result, out, wanted, quantity, console)
    if MPI.COMM_WORLD.rank == 0:
        _print(experiment, result, out, console)
    return result


def synthetic_measurement(
    kinds: Sequence[str],
    config: Config,
    truth: Config,
    nuisances: Sequence[str],
    noise: Mapping[str, float],
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
        noise: standard deviations by column, which replace the usual ones.
        seed: seed of the nuisances' draws and of the noise.
        out: folder for the data set.
        console: where the output is printed.

    Raises:
        ConfigError: one line naming the option, its value and what is allowed.
    """
    check_writable(out)
    asked = [Request.of(kind, config) for kind in kinds]
    with _bar("Synthetic measurement", asked, console) as (advance, tell):
        found = synthetic.measure(
            kinds,
            config,
            hidden=truth,
            nuisances=nuisances,
            noise={**synthetic.NOISE, **noise},
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
        result = _run(Request.of(each, config, fields=out / each.name), console)
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


def _quantity(text: str) -> Quantity:
    """The quantity that ``--colour-by`` asks for."""
    for quantity in get_args(Quantity):
        if text == quantity:
            return cast(Quantity, quantity)
    allowed = ", ".join(get_args(Quantity))
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


def _run(request: Request, console: Console) -> Result:
    runs = 1 + len(choices(request.config, request.gradients))
    with _bar(request.experiment.title, runs * [request], console) as (advance, tell):
        return follow(request, MPI.COMM_WORLD, advance, tell)


@contextmanager
def _bar(
    title: str, requests: Sequence[Request], console: Console
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
    wanted: list[float],
    colour_by: Quantity,
    console: Console,
) -> list[Path]:
    """Plot the curve, draw the finger at the pressures reached, return the files (on rank 0)."""

    def work() -> list[Path]:
        if not result.rows:
            return []
        with console.status("plotting and rendering"):
            from dolfingrip.charts import picture

            columns = result.columns()
            curve_file = picture.write([result.chart()], out / "curve.png", picture.Look(across=1))
            if experiment.pictures != "finger":
                module = importlib.import_module(f"dolfingrip.report.{experiment.pictures}")
                return [curve_file, *module.draw(out, result.config, columns)]
            reached = [p for p in wanted if np.isclose(result.column(PRESSURE.name), p).any()]
            if not reached:
                return [curve_file]
            from dolfingrip.report import render

            drawn = render.draw(
                out / "fields.pvd", reached, colour_by=colour_by, plate=_plate(result)
            )
            each = drawn.save_each(out)
            strip = [drawn.save_strip(out / "strip.png")] if len(reached) > 1 else []
            return [curve_file, *each, *strip]

    return on_root(MPI.COMM_WORLD, work) or []


def _plate(result: Result) -> Plate | None:
    """The force sensor for the picture; None if there is none."""
    if result.plate is None:
        return None
    from dolfingrip.report.scene import Plate

    return Plate(
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

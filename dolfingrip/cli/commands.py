"""What the commands do: run, plot, render, print."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import cast, get_args

import numpy as np
from mpi4py import MPI
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from dolfingrip.cli.options import check_writable
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import pressures_kPa, run, synthetic
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import find
from dolfingrip.experiments.result import Result, Row
from dolfingrip.experiments.undeformed import solid
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes import files
from dolfingrip.meshes.quality import check
from dolfingrip.report import curve, render
from dolfingrip.report.table import tabulate

DEMO = ("bending", "blocked_force")
DEMO_RENDERS_KPA = (0.0, 100.0, 200.0)


def write_mesh(config: Config, out: Path, console: Console) -> None:
    """Write ``finger.msh``, ``.vtk`` and ``.inp`` into ``out``."""

    check_writable(out)

    def work() -> None:
        with console.status("meshing"):
            mesh = solid(config)
        console.print(check(mesh).summary(), soft_wrap=True)
        _make(out)
        for suffix in (".msh", ".vtk", ".inp"):
            files.write(out / f"finger{suffix}", mesh)
            console.print(f"wrote {out / f'finger{suffix}'}", soft_wrap=True)

    on_root(MPI.COMM_WORLD, work)


def run_experiment(
    experiment: Experiment,
    config: Config,
    out: Path,
    renders: str | None,
    colour_by: str,
    console: Console,
) -> Result:
    """Run one experiment, print its table, plot and render."""
    wanted = _pressures(renders, config)
    quantity = _quantity(colour_by)
    check_writable(out)
    _warn(experiment, config, console)
    result = _run(experiment, config, out, console)
    on_root(MPI.COMM_WORLD, lambda: _report(experiment, result, out, wanted, quantity, console))
    if MPI.COMM_WORLD.rank == 0:
        _print(experiment, result, out, console)
    return result


def synthetic_measurement(
    experiments: str,
    config: Config,
    truth: Config,
    nuisances: Sequence[str],
    noise: Sequence[str],
    seed: int,
    out: Path,
    console: Console,
) -> None:
    """Simulate, disturb and write a data set."""
    kinds = experiments.split(",")
    unknown = [name for name in kinds if name not in synthetic.KINDS]
    if unknown:
        allowed = ", ".join(synthetic.KINDS)
        raise ConfigError(f"--experiments {unknown[0]}: allowed: {allowed}, joined by commas")
    channels = synthetic.noise_from(noise)
    check_writable(out)
    total = sum(len(find(kind).schedule(config)) for kind in kinds)
    with _bar("Synthetic measurement", total, console) as advance:
        found = synthetic.measure(
            kinds,
            config,
            hidden=truth,
            nuisances=nuisances,
            noise=channels,
            seed=seed,
            progress=advance,
        )
    synthetic.write(found, out)
    for failure in found.failures:
        console.print(f"[red]{failure.sentence()}[/red]", soft_wrap=True)
    console.print(
        f"{len(found.rows)} readings: {out / 'measured.csv'} and .toml; "
        f"what is behind them: {out / 'truth.toml'}",
        soft_wrap=True,
    )


def run_demo(config: Config, out: Path, console: Console) -> list[Result]:
    """Both experiments, one table, plots and renders."""
    check_writable(out)
    shown = [find(name) for name in DEMO]
    _warn(shown[0], config, console)
    wanted = [p for p in DEMO_RENDERS_KPA if p in pressures_kPa(config)]
    results = [_demonstrate(each, config, out / each.name, wanted, console) for each in shown]
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


def _demonstrate(
    experiment: Experiment, config: Config, out: Path, wanted: list[float], console: Console
) -> Result:
    result = _run(experiment, config, out, console)
    on_root(
        MPI.COMM_WORLD,
        lambda: _report(experiment, result, out, wanted, "displacement", console),
    )
    return result


def _make(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"--out {out}: {error.strerror}") from None


def _quantity(text: str) -> render.Quantity:
    """What ``--colour-by`` asks for."""
    for quantity in get_args(render.Quantity):
        if text == quantity:
            return cast(render.Quantity, quantity)
    allowed = ", ".join(get_args(render.Quantity))
    raise ConfigError(f"--colour-by {text}: allowed: {allowed}")


def _pressures(text: str | None, config: Config) -> list[float]:
    """Pressures of ``--render``, which must be among those the run lands on."""
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


def _warn(experiment: Experiment, config: Config, console: Console) -> None:
    for note in experiment.notes(config):
        console.print(f"[yellow]warning: {note}[/yellow]", soft_wrap=True, highlight=False)


def _run(experiment: Experiment, config: Config, out: Path, console: Console) -> Result:
    with _bar(experiment.title, len(experiment.schedule(config)), console) as advance:
        return run(experiment, config, out=out, progress=advance)


@contextmanager
def _bar(title: str, total: int, console: Console) -> Iterator[Callable[[Row], None]]:
    """A progress bar on a terminal, nothing elsewhere (a disabled one prints an empty line)."""
    if not console.is_terminal:
        yield lambda row: None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task(title, total=total, note="mesh and forms")

        def advance(row: Row) -> None:
            led = "pressure_kPa" if "pressure_kPa" in row else "displacement_mm"
            progress.update(task, advance=1, note=f"{row[led]:g} {led.rpartition('_')[2]}")

        yield advance


def _report(
    experiment: Experiment,
    result: Result,
    out: Path,
    wanted: list[float],
    colour_by: render.Quantity,
    console: Console,
) -> None:
    """Plot the curve and render the poses that were reached."""
    if not result.rows:
        return
    with console.status("plotting and rendering"):
        curve.plot(experiment, result.columns(), out / "curve.png", result.turning)
        if not wanted:
            return
        reached = [p for p in wanted if np.isclose(result.column("pressure_kPa"), p).any()]
        if not reached:
            return
        plate = _plate(result)
        fields = out / "fields.pvd"
        render.render_finger(fields, reached, out, colour_by=colour_by, plate=plate)
        if len(reached) > 1:
            render.render_strip(
                fields, reached, out / "strip.png", colour_by=colour_by, plate=plate
            )


def _plate(result: Result) -> render.Plate | None:
    """The force sensor, where there is one, for the picture."""
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
    if result.failure is not None:
        console.print(f"[red]{experiment.title} {result.failure.sentence()}[/red]", soft_wrap=True)

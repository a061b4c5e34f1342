"""What the commands do: they run, plot, draw and print."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import cast, get_args

import numpy as np
from mpi4py import MPI
from rich.console import Console

from dolfingrip.cli import progress
from dolfingrip.cli.options import check_writable
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import coupon, landings, landings_kPa, run, synthetic
from dolfingrip.experiments.notes import notes
from dolfingrip.experiments.run import Kind, Result, Row
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.report import curve, render
from dolfingrip.report.table import tabulate, tabulate_coupon

TITLES = {
    "bending": "Free bending",
    "blocked_force": "Blocked force",
    "coupon": "Uniaxial tension",
}
KINDS: tuple[Kind, ...] = get_args(Kind)
DEMO_RENDERS_KPA = (0.0, 100.0, 200.0)


def run_experiment(
    kind: Kind, config: Config, out: Path, renders: str | None, colour_by: str, console: Console
) -> Result:
    """Run one experiment, print its table, plot its curve and draw its poses.

    Args:
        kind: which experiment.
        config: of the finger.
        out: folder for results.
        renders: pressures to draw (kPa), joined by commas.
        colour_by: ``displacement`` or ``stretch``.
        console: where it is printed.

    Raises:
        ConfigError: on every rank, one line, before anything is computed.
    """
    wanted = _pressures(renders, config)
    quantity = _quantity(colour_by)
    check_writable(out)
    _warn(config, console)
    result = _run(kind, config, out, console)
    _pictures(result, out, wanted, quantity, console)
    if MPI.COMM_WORLD.rank == 0:
        _print(result, out, console)
    return result


def run_coupon(config: Config, out: Path, console: Console) -> Result:
    """Pull the coupon, print its table and plot its curve into ``out``."""
    check_writable(out)
    with _bar(TITLES["coupon"], len(coupon.readings(config)), console) as advance:
        result = coupon.run(config, out=out, progress=advance)
    if MPI.COMM_WORLD.rank == 0:
        if result.rows:
            columns = result.columns()
            curve.plot_coupon(columns, out / "curve.png")
            console.print(tabulate_coupon(columns, title=TITLES["coupon"]))
        _print_remarks(result, console)
        console.print(f"results: {out}", soft_wrap=True)
    return result


def fake_measurement(
    experiments: str,
    config: Config,
    truth: Config,
    nuisances: Sequence[str],
    noise: Sequence[str],
    seed: int,
    out: Path,
    console: Console,
) -> None:
    """Simulate, disturb and write a data set.

    Args:
        experiments: names joined by commas.
        config: what the data set says about itself.
        truth: what is simulated.
        nuisances: effects whose values are drawn from their priors.
        noise: standard deviations, ``COLUMN=VALUE``.
        seed: of nuisances and noise.
        out: folder for the data set.
        console: where it is printed.

    Raises:
        ConfigError: one line naming the option, its value and what is allowed.
    """
    kinds: list[synthetic.Kind] = []
    for name in experiments.split(","):
        known = [kind for kind in synthetic.KINDS if kind == name]
        if not known:
            allowed = ", ".join(synthetic.KINDS)
            raise ConfigError(f"--experiments {name}: allowed: {allowed}, joined by commas")
        kinds += known
    channels = synthetic.noise_from(noise)
    check_writable(out)
    readings = {kind: coupon.readings if kind == "coupon" else landings for kind in kinds}
    total = sum(len(of(config)) for of in readings.values())
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
    """Run both experiments, print one table; the pictures of each are there as soon as it ends."""
    check_writable(out)
    _warn(config, console)
    wanted = [p for p in DEMO_RENDERS_KPA if p in landings_kPa(config)]
    results = {}
    for kind in KINDS:
        result = results[kind] = _run(kind, config, out / kind, console)
        pictures = _pictures(result, out / kind, wanted, "displacement", console)
        for picture in pictures:
            console.print(f"wrote {picture}", soft_wrap=True)
    bending, blocked = results["bending"], results["blocked_force"]
    if MPI.COMM_WORLD.rank == 0:
        if bending.rows and blocked.rows:
            console.print(tabulate(bending.columns(), blocked.columns(), title="Reference finger"))
        for result in results.values():
            _print_remarks(result, console)
        console.print(f"pictures, tables and ParaView fields: {out}", soft_wrap=True)
    return [bending, blocked]


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
    known = landings_kPa(config)
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


def _warn(config: Config, console: Console) -> None:
    for note in notes(config):
        console.print(f"[yellow]warning: {note}[/yellow]", soft_wrap=True, highlight=False)


def _run(kind: Kind, config: Config, out: Path, console: Console) -> Result:
    with _bar(TITLES[kind], len(landings(config)), console) as advance:
        return run(kind, config, out=out, progress=advance)


@contextmanager
def _bar(title: str, total: int, console: Console) -> Iterator[Callable[[Row], None]]:
    """What to call with each row."""
    rows = 0
    what = f"{title.lower()} readings"
    with progress.shown(console, what, total=total, note="mesh and forms") as show:

        def advance(row: Row) -> None:
            nonlocal rows
            rows += 1
            led = "pressure_kPa" if "pressure_kPa" in row else "displacement_mm"
            show(rows, total, f"{row[led]:g} {led.rpartition('_')[2]}")

        yield advance


def _pictures(
    result: Result,
    out: Path,
    wanted: list[float],
    colour_by: render.Quantity,
    console: Console,
) -> list[Path]:
    """Plot the curve and draw the poses that were reached; the files, on rank 0."""

    def work() -> list[Path]:
        if not result.rows:
            return []
        with console.status("plotting and rendering"):
            curve_file = _curve(result, out / "curve.png")
            reached = [p for p in wanted if np.isclose(result.column("pressure_kPa"), p).any()]
            if not reached:
                return [curve_file]
            drawn = render.draw(
                out / "fields.pvd", reached, colour_by=colour_by, plate=_plate(result)
            )
            each = drawn.save_each(out)
            strip = [drawn.save_strip(out / "strip.png")] if len(reached) > 1 else []
            return [curve_file, *each, *strip]

    return on_root(MPI.COMM_WORLD, work) or []


def _curve(result: Result, file: Path) -> Path:
    """Plot the experiment's quantity against pressure."""
    if result.kind == "bending":
        return curve.plot_bending(result.columns(), file)
    return curve.plot_blocked_force(result.columns(), file, result.turning)


def _plate(result: Result) -> render.Plate | None:
    """The force sensor, where there is one, for the picture."""
    if result.plate is None:
        return None
    return render.Plate(
        point_mm=result.plate.point_mm,
        normal=result.plate.normal,
        contact_length_mm=result.config.plate.contact_length_mm,
    )


def _print(result: Result, out: Path, console: Console) -> None:
    if result.rows:
        alone = {result.kind: result.columns()}
        console.print(tabulate(**alone, title=TITLES[result.kind]))
    _print_remarks(result, console)
    console.print(f"results: {out}", soft_wrap=True)


def _print_remarks(result: Result, console: Console) -> None:
    if result.turning is not None:
        console.print(result.turning.sentence(), soft_wrap=True)
    if result.failure is not None:
        console.print(
            f"[red]{TITLES[result.kind]} {result.failure.sentence()}[/red]", soft_wrap=True
        )

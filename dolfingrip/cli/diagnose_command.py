"""``dolfingrip diagnose``: what the simulation gets wrong about measured data, and why."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, check_writable, console
from dolfingrip.config import ConfigError


def diagnose(
    data: Annotated[
        list[Path], typer.Argument(metavar="DATA.csv…", help="Measured; a TOML beside each.")
    ],
    out: Out = Path("out/diagnosis"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes that simulate.")] = 2,
    store: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Simulations; default: simulations/ in --out."),
    ] = None,
    effects: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME,…", help="Effects to try; default: the whole catalogue."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Stop after the screen.")] = False,
) -> None:
    """Find out what the simulation gets wrong about measured data, and why."""
    if MPI.COMM_WORLD.size > 1:
        raise ConfigError(f"mpirun -n {MPI.COMM_WORLD.size}: allowed: --workers, without mpirun")
    from dolfingrip.cli import progress
    from dolfingrip.design.campaign.campaign import SchedulerGone
    from dolfingrip.diagnosis import diagnose as work
    from dolfingrip.diagnosis.results import write

    resolved = configuration.load(config, overrides or ())
    check_writable(out)
    screen = console()
    names = [name.strip() for name in effects.split(",")] if effects else None
    try:
        with progress.shown(screen, "simulations") as show:
            settings = work.Settings(
                workers, store, quick, names,
                lambda text: screen.print(text, soft_wrap=True),
                lambda standing: show(
                    standing.done + standing.failed, standing.total, f"{standing.failed} failed"
                ),
            )  # fmt: skip
            found = work.diagnose(data, resolved, out, settings)
    except SchedulerGone as gone:
        screen.print(f"[red]{gone}[/red]", soft_wrap=True)
        raise typer.Exit(1) from None
    result = write(found, resolved, data, out)
    from dolfingrip.report import diagnosis as pictures

    pictures.draw(result.pictures, out)
    for line in result.text.splitlines()[:3]:
        screen.print(line.removeprefix("# "), soft_wrap=True, markup=False)
    screen.print(f"diagnosis: {out}", soft_wrap=True)

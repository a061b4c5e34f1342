"""``dolfingrip diagnose``: what the simulation gets wrong about measured data, and why."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, check_writable, console, one_process
from dolfingrip.cli.simulations import (
    Effects,
    StoreFolder,
    Workers,
    effect_names,
    resumable,
)


def diagnose(
    data: Annotated[
        list[Path], typer.Argument(metavar="DATA.csv…", help="Measured; each CSV has a TOML.")
    ],
    out: Out = Path("out/diagnosis"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    workers: Workers = 2,
    store: StoreFolder = None,
    effects: Effects = None,
    campaign: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Of designs: the best by the extended model, too."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Stop after the screen.")] = False,
    anew: Annotated[
        bool, typer.Option("--anew", help="Simulate what comes with the package, too.")
    ] = False,
) -> None:
    """Find out what the simulation gets wrong about measured data, and why."""
    one_process("--workers, without mpirun")
    from dolfingrip.cli import progress
    from dolfingrip.diagnosis import diagnose as work
    from dolfingrip.diagnosis.results import write

    resolved = configuration.load(config, dict(overrides or ()))
    check_writable(out)
    screen = console()
    names = effect_names(effects)
    kept = store or out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        settings = work.Settings(
                workers, kept, quick, names, campaign, anew,
                lambda text: screen.print(text, soft_wrap=True),
                show,
            )  # fmt: skip
        found = work.diagnose(data, resolved, out, settings)
    result = write(found, data, out)
    from dolfingrip.report import diagnosis as pictures

    pictures.draw(result.result, result.readings, out)
    for line in result.text.splitlines()[:3]:
        screen.print(line.removeprefix("# "), soft_wrap=True)
    screen.print(f"diagnosis: {out}", soft_wrap=True)

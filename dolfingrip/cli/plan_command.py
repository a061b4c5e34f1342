"""``dolfingrip plan-experiment``: what a rig could find out, before anything is measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, check_writable, console
from dolfingrip.config import ConfigError


def plan_experiment(
    rig: Annotated[
        Path | None,
        typer.Argument(metavar="[RIG.toml]", help="Set-up and [protocol]; default: the paper's."),
    ] = None,
    out: Out = Path("out/plan"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--with", metavar="KEY=VALUE", help="Of [protocol], e.g. cycles=3."),
    ] = None,
    noise: Annotated[
        list[str] | None,
        typer.Option("--noise", metavar="COLUMN=STD", help="e.g. angle_deg=0.2; repeatable."),
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes that simulate.")] = 2,
    store: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Simulations; default: simulations/ in --out."),
    ] = None,
    effects: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME,…", help="Effects to try; default: the whole catalogue."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Only additions whose simulations are at hand.")
    ] = False,
) -> None:
    """Which effects a rig could name, at which strength, and what to add to it."""
    if MPI.COMM_WORLD.size > 1:
        raise ConfigError(f"mpirun -n {MPI.COMM_WORLD.size}: allowed: --workers, without mpirun")
    from dolfingrip.cli import progress
    from dolfingrip.design.campaign.campaign import SchedulerGone
    from dolfingrip.diagnosis.plan import outcome
    from dolfingrip.diagnosis.plan import plan as work
    from dolfingrip.diagnosis.tried import check_effects
    from dolfingrip.experiments.synthetic import noise_from

    resolved = configuration.load(config, overrides or ())
    check_writable(out)
    screen = console()
    names = [name.strip() for name in effects.split(",")] if effects else None
    check_effects(names)
    asked = noise or []
    told = {key: std for key, std in noise_from(asked).items()
            if any(each.startswith(f"{key}=") for each in asked)}  # fmt: skip
    try:
        with progress.shown(screen, "simulations", at_once=True) as show:
            settings = work.Settings(
                store or out / "simulations", workers, quick, names,
                lambda text: screen.print(text, soft_wrap=True),
                lambda standing: show(
                    standing.done + standing.failed, standing.total, f"{standing.failed} failed"
                ),
            )  # fmt: skip
            found = outcome.outcome_of(work.plan(rig, resolved, settings, changes or (), told))
    except SchedulerGone as gone:
        screen.print(f"[red]{gone}[/red]", soft_wrap=True)
        raise typer.Exit(1) from None
    out.mkdir(parents=True, exist_ok=True)
    found.write(out / "plan.json")
    text = outcome.text(found)
    (out / "plan.md").write_text(text, encoding="utf-8")
    from dolfingrip.report import plan as pictures

    pictures.draw(found.model_dump(), out / "plan.png")
    screen.print(text, soft_wrap=True, markup=False)
    screen.print(f"plan: {out}", soft_wrap=True)

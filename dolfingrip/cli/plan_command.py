"""``dolfingrip plan-experiment``: the effects that a rig could name, before measuring."""

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


def plan_experiment(
    rig: Annotated[
        Path | None,
        typer.Argument(metavar="[RIG.toml]", help="Set-up and \\[protocol]; default: the paper's."),
    ] = None,
    out: Out = Path("out/plan"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--with", metavar="KEY=VALUE", help="Of \\[protocol], e.g. cycles=3."),
    ] = None,
    noise: Annotated[
        list[str] | None,
        typer.Option("--noise", metavar="COLUMN=STD", help="e.g. angle_deg=0.2; repeatable."),
    ] = None,
    workers: Workers = 2,
    store: StoreFolder = None,
    effects: Effects = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Only additions whose simulations are at hand.")
    ] = False,
) -> None:
    """Which effects a rig could name, at which strength, and what to add to it."""
    one_process("--workers, without mpirun")
    from dolfingrip.cli import progress
    from dolfingrip.diagnosis.plan import outcome
    from dolfingrip.diagnosis.plan import plan as work
    from dolfingrip.diagnosis.tried import check_effects
    from dolfingrip.experiments.synthetic import assigned_noise

    resolved = configuration.load(config, overrides or ())
    check_writable(out)
    screen = console()
    names = effect_names(effects)
    check_effects(names)
    told = assigned_noise(noise or ())
    kept = store or out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        settings = work.Settings(
                kept, workers, quick, names,
                lambda text: screen.print(text, soft_wrap=True),
                show,
            )  # fmt: skip
        found = outcome.outcome_of(work.plan(rig, resolved, settings, changes or (), told))
    out.mkdir(parents=True, exist_ok=True)
    found.write(out / "plan.json")
    text = outcome.text(found)
    (out / "plan.md").write_text(text, encoding="utf-8")
    from dolfingrip.report import plan as pictures

    pictures.draw(found.model_dump(), out / "plan.png")
    screen.print(text, soft_wrap=True, markup=False)
    screen.print(f"plan: {out}", soft_wrap=True)

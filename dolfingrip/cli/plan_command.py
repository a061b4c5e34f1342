"""``dolfingrip plan-experiment``: the effects that a rig could name, before measuring."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dolfingrip import config as configuration
from dolfingrip.cli.options import (
    ConfigFile,
    Noise,
    Out,
    Overrides,
    assigned,
    check_writable,
    console,
    one_process,
)
from dolfingrip.cli.simulations import (
    Effects,
    StoreFolder,
    Workers,
    effect_names,
    resumable,
)
from dolfingrip.files import whole

if TYPE_CHECKING:
    from rich.table import Table

    from dolfingrip.files.plan import PlanFile

NAMES = 26
"""Width, in characters, to which lists of names are wrapped."""


def tables(found: PlanFile) -> list[Table]:
    """The effects and the additions of a plan, for a terminal of 80 columns."""
    from dolfingrip.report.table import of_columns

    def wrapped(text: str) -> str:
        return "\n".join(textwrap.wrap(text, NAMES)) or "–"

    effects = {
        "Effect": [each.effect for each in found.effects],
        "Strength (σ)": [f"{each.strength_sigma:z.1f}" for each in found.effects],
        "Named from × ordinary": [
            "–" if each.named_from is None else f"{each.named_from:.2g}" for each in found.effects
        ],
        "Named": [f"{each.share:z.2f}" for each in found.effects],
        "Its class": [f"{each.class_share:z.2f}" for each in found.effects],
        "Not told from": [wrapped(", ".join(each.confused_with[:4])) for each in found.effects],
    }
    additions = {
        "Addition": [wrapped(each.name) for each in found.additions],
        "Minutes": [f"{each.minutes:.0f}" for each in found.additions],
        "Named": [f"{each.share:z.2f}" for each in found.additions],
        "Gain (% a minute)": [f"{100 * each.gain_per_minute:+z.2f}" for each in found.additions],
        "Newly named": [wrapped(", ".join(each.lifts[:4])) for each in found.additions],
    }
    left = ("Effect", "Not told from", "Addition", "Newly named")
    shown = [of_columns(effects, "Effects", left)]
    return [*shown, of_columns(additions, "Additions", left)] if found.additions else shown


def plan_experiment(
    rig: Annotated[
        Path | None,
        typer.Argument(metavar="[RIG.toml]", help="Set-up and \\[protocol]; default: the paper's."),
    ] = None,
    out: Out = Path("out/plan"),
    config: ConfigFile = None,
    overrides: Overrides = None,
    changes: Annotated[
        list[Any] | None,
        typer.Option(
            "--with", metavar="KEY=VALUE", help="Of \\[protocol], e.g. cycles=3.", callback=assigned
        ),
    ] = None,
    noise: Noise = None,
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
    from dolfingrip.experiments.synthetic import check_noise

    resolved = configuration.load(config, dict(overrides or ()))
    check_writable(out)
    screen = console()
    names = effect_names(effects)
    check_effects(names)
    check_noise(told := dict(noise or ()))
    kept = store or out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        settings = work.Settings(
                kept, workers, quick, names,
                lambda text: screen.print(text, soft_wrap=True),
                show,
            )  # fmt: skip
        found = work.plan(rig, resolved, settings, dict(changes or ()), told)
    found.write(out)
    text = outcome.text(found)
    whole.write(out / "plan.md", text)
    from dolfingrip.charts import picture
    from dolfingrip.report import plan as pictures

    picture.write(pictures.charts(found), out / "plan.png", pictures.look(found))
    screen.print(text.partition("\n|")[0].lstrip("# "), soft_wrap=True)
    for table in tables(found):
        screen.print(table)
        screen.print()
    for warning in found.warnings:
        screen.print(f"- {warning}", soft_wrap=True)
    screen.print(f"plan: {out}", soft_wrap=True)

"""``dolfingrip optimise``: the Pareto front of a surrogate, and finite elements along it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import typer
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import (
    Screen,
    check_writable,
    console,
    one_process,
    resumable,
)
from dolfingrip.cli.doe_commands import DEFAULTS
from dolfingrip.cli.settings import OptimiseSettings
from dolfingrip.config import Change, Config
from dolfingrip.design.optimum import files, optimum
from dolfingrip.design.optimum.finite_elements import evaluator
from dolfingrip.design.optimum.genetic import Settings
from dolfingrip.design.optimum.resolve import Resolved
from dolfingrip.design.surrogate import surrogate as network
from dolfingrip.files.optimum import ChosenDesign, OptimumFile
from dolfingrip.files.surrogate import SurrogateFile
from dolfingrip.jobs.cluster import Where
from dolfingrip.report.design import label, surrogate_front
from dolfingrip.report.table import of_columns


def optimise(asked: OptimiseSettings) -> None:
    """Find the Pareto front by NSGA-II, choose by the COG limit, compute the choice again."""
    one_process("--workers, without mpirun")

    model = network.load(asked.surrogate)
    campaign = model.facts.get("campaign") or {}
    base = _base(campaign, asked.config, asked.overrides) if asked.resolve else None
    genetic = Settings(
        asked.population, asked.generations, asked.crossover, asked.mutation, asked.seed
    )
    check_writable(asked.out)
    screen = console()
    with progress.shown(screen, "generations") as show:
        found = optimum.find(
            model,
            sorted(set(asked.cog_max)),
            genetic,
            lambda done: show(done, asked.generations),
            along=asked.along,
        )
    files.write_front(found, asked.out)
    screen.say(
        f"front: {len(found.front)} points, COG offset {found.front.cog_mm[0]:z.2f} to "
        f"{found.front.cog_mm[-1]:z.2f} mm, force {found.front.force_N[0]:.2f} to "
        f"{found.front.force_N[-1]:.2f} N"
    )
    resolved: list[Resolved] = []
    if base is not None:
        objective = {"objective": campaign["objective"]} if "objective" in campaign else {}
        shown = progress.jobs(screen, "designs", progress.FEW)
        with resumable(screen, asked.out / "fem"), shown as advance:
            evaluate = evaluator(
                base,
                model.output_names,
                asked.out / "fem",
                Where(workers=asked.workers),
                progress=advance,
                **objective,
            )
            resolved = optimum.compute(found, evaluate)
    facts = files.write(found, resolved, asked.out)
    learnt = SurrogateFile.read(asked.surrogate)
    chart = surrogate_front(facts, learnt.failed_designs, learnt.designs(asked.surrogate))
    picture.write([chart], asked.out / "pareto.png", picture.Look(across=1, key="above"))
    _print(facts, screen)
    screen.say(f"results: {asked.out}")
    if found.missed or any(one.failure for one in facts.designs):
        raise typer.Exit(1)


def _base(campaign: dict[str, Any], file: Path | None, overrides: Change) -> Config:
    """The configuration that a design's inputs are set in."""

    if file is not None or "base" not in campaign:
        return configuration.load(file, overrides, DEFAULTS)
    return configuration.changed(configuration.from_dict(campaign["base"]), overrides)


def _print(facts: OptimumFile, screen: Screen) -> None:
    for limit in facts.limits_below_the_front:
        screen.print(f"no design of the front has a COG offset up to {limit:g} mm")
    if facts.designs:
        screen.print(_table(facts.designs))
    for one in facts.designs:
        if one.failure:
            screen.say(f"{one.role} design failed: {one.failure}", style="red")
    for name, error in facts.surrogate_error_on_front.items():
        screen.say(
            f"surrogate on {error.designs} points along the front, {name}: RMS error "
            f"{error.rms:.3g} ({100 * error.relative:.2g} %), largest {error.largest:.3g}"
        )


def _table(designs: Sequence[ChosenDesign]) -> Table:
    """The chosen designs; by the surrogate, and by finite elements where they are checked."""

    first, roles = designs[0], "Design"
    columns = {roles: [_role(one) for one in designs]}
    for name in first.inputs:
        columns[label(name)] = [f"{one.inputs[name]:z.3f}" for one in designs]
    for name in first.surrogate:
        columns[label(name)] = [f"{one.surrogate[name]:z.3f}" for one in designs]
        if first.resolved:
            what, bracket, unit = label(name).partition(" (")
            columns[f"{what} by FEM{bracket}{unit}"] = [
                "failed" if one.fem is None else f"{one.fem[name]:z.3f}" for one in designs
            ]
    if first.resolved:
        gains = [one.gain for one in designs]
        columns["Gain (%)"] = ["–" if gain is None else f"{100 * gain:+z.1f}" for gain in gains]
    table = of_columns(columns, "Designs", left=(roles,))
    if first.resolved:
        table.caption = "by the surrogate; FEM: by finite elements; gain: force over the original's"
    return table


def _role(design: ChosenDesign) -> str:
    return design.role if design.limit is None else f"{design.role} ≤ {design.limit:g} mm"

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
from dolfingrip.cli.console import Screen, check_writable, console, one_process, resumable
from dolfingrip.cli.doe_commands import DEFAULTS
from dolfingrip.cli.settings import OptimiseSettings, TradeOffSettings
from dolfingrip.config import Change, Config, ConfigError
from dolfingrip.design.campaign.plan import OBJECTIVE
from dolfingrip.design.optimum import optimum
from dolfingrip.design.optimum.genetic import NSGA2Settings
from dolfingrip.design.optimum.study_file import trade_off
from dolfingrip.design.surrogate import surrogate as network
from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.optimum import ChosenDesign, OptimumFile
from dolfingrip.jobs.cluster import Where
from dolfingrip.report.design import label, surrogate_front
from dolfingrip.report.table import of_columns
from dolfingrip.sections.errors import shown


def optimise(asked: OptimiseSettings) -> None:
    """Find the Pareto front by NSGA-II, choose by a limit, compute the choice again."""
    one_process("--workers, without mpirun")

    model = network.load(asked.surrogate)
    campaign = model.facts.campaign or {}
    base = _base(campaign, asked.config, asked.overrides) if asked.resolve else None
    computed_by = str(campaign.get("objective", OBJECTIVE))
    foreign = computed_by != asked.objective and not computed_by.startswith("dolfingrip.")
    if asked.resolve and foreign:
        raise ConfigError(
            f"{asked.surrogate}: objective = {shown(computed_by)}: code that is not of this "
            f"package; allowed: --no-resolve, or --objective {computed_by}, which runs it"
        )
    objectives = objectives_of(asked, model.output_names)
    genetic = NSGA2Settings(
        asked.population, asked.generations, asked.crossover, asked.mutation, asked.seed
    )
    check_writable(asked.out)
    screen = console()
    with progress.shown(screen, "generations") as show:
        found = optimum.find(
            model,
            objectives,
            sorted({*asked.at_most, *asked.at_least}),
            genetic,
            lambda done: show(done, asked.generations),
        )
    optimum.write_front(found, asked.out)
    ends = [found.front[0].surrogate, found.front[-1].surrogate]
    reach = ", ".join(
        f"{label(each.title)} {ends[0][each.title]:z.2f} to {ends[1][each.title]:z.2f}"
        for each in objectives
    )
    screen.say(f"front: {len(found.front)} points, {reach}")
    if base is not None:
        jobs = progress.jobs(screen, "designs", progress.FEW)
        with resumable(screen, asked.out / "fem"), jobs as advance:
            evaluate = optimum.evaluator(
                base,
                (*model.output_names, *asked.also),
                asked.out / "fem",
                Where(workers=asked.workers),
                progress=advance,
                objective=computed_by,
            )
            found = optimum.resolve(found, asked.along, evaluate)
    optimum.write(found, asked.out)
    learnt = model.facts.designs(asked.surrogate)
    chart = surrogate_front(found, model.facts.failed_designs, learnt)
    picture.write([chart], asked.out / "pareto.png", picture.Look(across=1, key="above"))
    _print(found, screen)
    screen.say(f"results: {asked.out}")
    if found.limits_below_the_front or any(one.failure for one in found.designs):
        raise typer.Exit(1)


def objectives_of(
    asked: TradeOffSettings, outputs: Sequence[str]
) -> tuple[NamedObjective, NamedObjective]:
    """Return the two objectives that a command asks for.

    Args:
        asked: settings of the command.
        outputs: of the surrogate; the defaults are its first two.

    Returns:
        The limited objective, the improved one.

    Raises:
        ConfigError: one line, where there are not just two of them.
    """
    given = (asked.maximise, asked.minimise)
    against = asked.against or next(each for each in outputs if each not in given)
    maximise = asked.maximise
    if not any(given):
        maximise = next((each for each in outputs if each != against), None)
    return trade_off(against, asked.at_most, asked.at_least, maximise, asked.minimise)


def _base(campaign: dict[str, Any], file: Path | None, overrides: Change) -> Config:
    """The configuration that a design's inputs are set in."""

    if file is not None or "base" not in campaign:
        return configuration.load(file, overrides, DEFAULTS)
    return configuration.changed(configuration.from_dict(campaign["base"]), overrides)


def _print(facts: OptimumFile, screen: Screen) -> None:
    first, second = facts.objectives
    for limit in facts.limits_below_the_front:
        screen.print(f"no design of the front has {first.title} {first.sense} {limit:g}")
    if facts.designs:
        screen.print(_table(facts.designs, first, second))
    for one in facts.designs:
        if one.failure:
            screen.say(f"{one.role} design failed: {one.failure}", style="red")
    for name, error in facts.surrogate_error_on_front.items():
        screen.say(
            f"surrogate on {error.designs} points along the front, {name}: RMS error "
            f"{error.rms:.3g} ({100 * error.relative:.2g} %), largest {error.largest:.3g}"
        )


def _table(
    designs: Sequence[ChosenDesign], limited: NamedObjective, improved: NamedObjective
) -> Table:
    """The chosen designs; by the surrogate, and by finite elements where they are checked."""

    first, roles = designs[0], "Design"
    columns = {roles: [_role(one, limited) for one in designs]}
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
        name = label(improved.title).partition(" (")[0]
        table.caption = (
            f"by the surrogate; FEM: by finite elements; gain over the original's: {name}"
        )
    return table


def _role(design: ChosenDesign, limited: NamedObjective) -> str:
    if design.limit is None:
        return design.role
    return f"{design.role} {'≤' if limited.sign > 0 else '≥'} {design.limit:g} {limited.unit}"

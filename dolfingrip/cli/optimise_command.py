"""``dolfingrip optimise``: the Pareto front of a surrogate, and finite elements along it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, check_writable, console, one_process
from dolfingrip.cli.simulations import resumable
from dolfingrip.config import Change, Config

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dolfingrip.design.optimum.resolve import Resolved
    from dolfingrip.files.optimum import ChosenDesign, OptimumFile


def optimise(
    surrogate: Annotated[Path, typer.Argument(help="Folder of the surrogate.")],
    out: Out = Path("out/optimum"),
    cog_max: Annotated[
        list[float] | None,
        typer.Option("--cog-max", metavar="mm", help="Largest COG offset; repeatable. Default: 3."),
    ] = None,
    population: Annotated[int, typer.Option(min=4, help="Designs in a generation.")] = 1000,
    generations: Annotated[int, typer.Option(min=1, help="The random first one counts.")] = 200,
    crossover: Annotated[float, typer.Option(min=0, max=1, help="Rate, per mating.")] = 0.9,
    mutation: Annotated[float, typer.Option(min=0, max=1, help="Rate, per input.")] = 0.5,
    seed: Annotated[int, typer.Option(min=0, help="Of NSGA-II.")] = 1,
    resolve: Annotated[
        bool, typer.Option(help="Compute the choices and --along by finite elements.")
    ] = True,
    along: Annotated[int, typer.Option(min=0, help="Points of the front to compute again.")] = 10,
    workers: Annotated[int, typer.Option(min=1, help="Local processes of --resolve.")] = 1,
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Find the Pareto front by NSGA-II, choose by the COG limit, compute the choice again.

    Finite elements take the configuration of the campaign that the surrogate learnt from, unless
    --config names another; --set changes it. What they computed is kept in OUT/fem.
    """
    one_process("--workers, without mpirun")
    from dolfingrip.charts import picture
    from dolfingrip.cli import progress
    from dolfingrip.design.optimum import files, optimum
    from dolfingrip.design.optimum.finite_elements import evaluator
    from dolfingrip.design.optimum.genetic import Settings
    from dolfingrip.design.surrogate import surrogate as network
    from dolfingrip.files.surrogate import SurrogateFile
    from dolfingrip.jobs.cluster import Where
    from dolfingrip.report.design import surrogate_front

    model = network.load(surrogate)
    campaign = model.facts.get("campaign") or {}
    base = _base(campaign, config, dict(overrides or ())) if resolve else None
    settings = Settings(population, generations, crossover, mutation, seed)
    check_writable(out)
    screen = console()
    with progress.shown(screen, "generations") as show:
        found = optimum.find(
            model,
            sorted(set(cog_max or [3.0])),
            settings,
            lambda done: show(done, generations),
            along=along,
        )
    files.write_front(found, out)
    screen.print(
        f"front: {len(found.front)} points, COG offset {found.front.cog_mm[0]:z.2f} to "
        f"{found.front.cog_mm[-1]:z.2f} mm, force {found.front.force_N[0]:.2f} to "
        f"{found.front.force_N[-1]:.2f} N",
        soft_wrap=True,
    )
    resolved: list[Resolved] = []
    if base is not None:
        objective = {"objective": campaign["objective"]} if "objective" in campaign else {}
        shown = progress.jobs(screen, "designs", progress.FEW)
        with resumable(screen, out / "fem"), shown as advance:
            evaluate = evaluator(
                base,
                model.output_names,
                out / "fem",
                Where(workers=workers),
                progress=advance,
                **objective,
            )
            resolved = optimum.compute(found, evaluate)
    facts = files.write(found, resolved, out)
    learnt = SurrogateFile.read(surrogate)
    chart = surrogate_front(facts, learnt.failed_designs, learnt.designs(surrogate))
    picture.write([chart], out / "pareto.png", picture.Look(across=1, key="above"))
    _print(facts, screen)
    screen.print(f"results: {out}", soft_wrap=True)
    if found.missed or any(one.failure for one in facts.designs):
        raise typer.Exit(1)


def _base(campaign: dict[str, Any], file: Path | None, overrides: Change) -> Config:
    """The configuration that a design's inputs are set in."""
    from dolfingrip.cli.doe_commands import DEFAULTS

    if file is not None or "base" not in campaign:
        return configuration.load(file, overrides, DEFAULTS)
    return configuration.changed(configuration.from_dict(campaign["base"]), overrides)


def _print(facts: OptimumFile, screen: Console) -> None:
    for limit in facts.limits_below_the_front:
        screen.print(f"no design of the front has a COG offset up to {limit:g} mm")
    if facts.designs:
        screen.print(_table(facts.designs))
    for one in facts.designs:
        if one.failure:
            screen.print(f"{one.role} design failed: {one.failure}", style="red", soft_wrap=True)
    for name, error in facts.surrogate_error_on_front.items():
        screen.print(
            f"surrogate on {error.designs} points along the front, {name}: RMS error "
            f"{error.rms:.3g} ({100 * error.relative:.2g} %), largest {error.largest:.3g}",
            soft_wrap=True,
        )


def _table(designs: Sequence[ChosenDesign]) -> Table:
    """The chosen designs; by the surrogate, and by finite elements where they are checked."""
    from dolfingrip.report.design import label
    from dolfingrip.report.table import of_columns

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

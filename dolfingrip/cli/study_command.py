"""``dolfingrip study``: how NSGA-II's choice scatters with its hyperparameters."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dolfingrip.cli.options import Out, check_writable, console, one_process
from dolfingrip.cli.simulations import resumable

if TYPE_CHECKING:
    from dolfingrip.design.optimum.scatter import Combination


def study(
    surrogate: Annotated[Path, typer.Argument(help="Folder of the surrogate.")],
    out: Out = Path("out/study"),
    cog_max: Annotated[
        float, typer.Option("--cog-max", metavar="mm", help="Largest COG offset.")
    ] = 3.0,
    population: Annotated[
        list[int] | None, typer.Option(min=4, help="Repeatable. Default: 50, 100, 500, 1000.")
    ] = None,
    generations: Annotated[
        list[int] | None, typer.Option(min=1, help="Repeatable. Default: 10, 50, 100, 200.")
    ] = None,
    crossover: Annotated[
        list[float] | None,
        typer.Option(min=0, max=1, help="Rate; repeatable. Default: 0.9, 0.8, 0.6, 0.4."),
    ] = None,
    mutation: Annotated[
        list[float] | None,
        typer.Option(min=0, max=1, help="Rate; repeatable. Default: 0.01, 0.1, 0.5, 0.8."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=2, help="Runs of each combination.")] = 10,
    processes: Annotated[
        int | None, typer.Option(min=1, help="At a time. Default: one for each core.")
    ] = None,
) -> None:
    """Try NSGA-II's hyperparameters: all combinations, each with several seeds."""
    one_process("--processes, without mpirun")
    from dolfingrip.cli import progress
    from dolfingrip.design.optimum import scatter
    from dolfingrip.design.optimum import study as work
    from dolfingrip.design.surrogate import surrogate as network
    from dolfingrip.files import table

    default = work.Plan()
    plan = work.Plan(
        tuple(dict.fromkeys(population or default.populations)),
        tuple(dict.fromkeys(generations or default.generations)),
        tuple(dict.fromkeys(crossover or default.crossovers)),
        tuple(dict.fromkeys(mutation or default.mutations)),
        seeds,
        cog_max,
    )
    check_writable(out)
    names = network.load(surrogate).input_names
    screen = console()
    with resumable(screen, out), progress.jobs(screen, "runs") as show:
        found = work.run(surrogate, out, plan, processes or len(os.sched_getaffinity(0)), show)
    combinations = scatter.combine(found.choices, len(names))
    best = scatter.best(combinations)
    table.write(out / "combinations.csv", scatter.rows(combinations, names))
    table.write(out / "best.csv", scatter.rows(best, names))
    screen.print(
        f"{len(combinations)} combinations of {seeds} seeds, from {len(plan.runs())} runs of "
        f"NSGA-II ({found.cpu_s / 60:.1f} minutes of one core)",
        soft_wrap=True,
    )
    if not best:
        screen.print(f"no front of all seeds reaches a COG offset of {cog_max:g} mm")
        raise typer.Exit(1)
    _plot(best, names, out)
    screen.print(_table(best, names))
    screen.print(f"study: {out}", soft_wrap=True)


def _plot(best: list[Combination], names: tuple[str, ...], out: Path) -> None:
    import numpy as np

    from dolfingrip.charts import picture
    from dolfingrip.report.design import scatter

    sd = {}
    for population in {one.population for one in best}:
        line = [one for one in best if one.population == population]
        sd[population] = [one.generations for one in line], np.array([one.sd for one in line])
    look = picture.Look(panel_in=(4.0, 4.0), titled=True)
    picture.write(scatter(names, sd), out / "scatter.png", look)


def _table(best: list[Combination], names: tuple[str, ...]) -> object:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from dolfingrip.report.design import label

    title = "Best rates, and their choice: mean ± standard deviation over the seeds"
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1))
    short = [label(name) for name in names]
    rates = ("popu-\nlation", "gene-\nrations", "cross-\nover", "muta-\ntion")
    for heading in (*rates, *short, "force (N)"):
        table.add_column(heading, justify="right", no_wrap=True)
    for one in best:
        chosen = [f"{m:z.4f} ± {s:.4f}" for m, s in zip(one.mean, one.sd, strict=True)]
        table.add_row(
            str(one.population),
            str(one.generations),
            f"{one.crossover:g}",
            f"{one.mutation:g}",
            *chosen,
            f"{one.mean_force_N:.4f}",
        )
    return table

"""``dolfingrip study``: how NSGA-II's choice scatters with its hyperparameters."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import check_writable, console, one_process, resumable
from dolfingrip.cli.optimise_command import objectives_of
from dolfingrip.cli.settings import StudySettings
from dolfingrip.config import ConfigError
from dolfingrip.design.optimum import scatter
from dolfingrip.design.optimum import study as work
from dolfingrip.design.optimum.scatter import Combination
from dolfingrip.design.surrogate import surrogate as network
from dolfingrip.files import table
from dolfingrip.report import design as pictures


def study(asked: StudySettings) -> None:
    """Try NSGA-II's hyperparameters: all combinations, each with several seeds."""
    one_process("--processes, without mpirun")

    model = network.load(asked.surrogate)
    objectives = objectives_of(asked, model.output_names)
    if len(asked.at_most + asked.at_least) != 1:
        raise ConfigError("--at-most, --at-least: allowed: one of them, to choose designs by")
    (limit,) = asked.at_most + asked.at_least
    plan = work.HyperparameterStudy(
        objectives,
        limit,
        tuple(dict.fromkeys(asked.population)),
        tuple(dict.fromkeys(asked.generations)),
        tuple(dict.fromkeys(asked.crossover)),
        tuple(dict.fromkeys(asked.mutation)),
        asked.seeds,
    )
    check_writable(asked.out)
    names, improved = model.input_names, objectives[1].title
    screen = console()
    processes = asked.processes or len(os.sched_getaffinity(0))
    with resumable(screen, asked.out), progress.jobs(screen, "runs") as show:
        found = work.run(asked.surrogate, asked.out, plan, processes, show)
    combinations = scatter.combine(found.choices, len(names))
    best = scatter.best(combinations)
    table.write(asked.out / "combinations.csv", scatter.rows(combinations, names, improved))
    table.write(asked.out / "best.csv", scatter.rows(best, names, improved))
    screen.say(
        f"{len(combinations)} combinations of {asked.seeds} seeds, from {len(plan.runs())} runs of "
        f"NSGA-II ({found.cpu_s / 60:.1f} minutes of one core)"
    )
    if not best:
        first = objectives[0]
        screen.print(f"no front of all seeds has {first.title} {first.sense} {limit:g}")
        raise typer.Exit(1)
    _plot(best, names, asked.out)
    screen.print(_table(best, names, improved))
    screen.say(f"study: {asked.out}")


def _plot(best: list[Combination], names: tuple[str, ...], out: Path) -> None:

    sd = {}
    for population in {one.population for one in best}:
        line = [one for one in best if one.population == population]
        sd[population] = [one.generations for one in line], np.array([one.sd for one in line])
    look = picture.Look(panel_in=(4.0, 4.0), titled=True)
    picture.write(pictures.scatter(names, sd), out / "scatter.png", look)


def _table(best: list[Combination], names: tuple[str, ...], improved: str) -> object:

    title = "Best rates, and their choice: mean ± standard deviation over the seeds"
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1))
    short = [pictures.label(name) for name in names]
    rates = ("popu-\nlation", "gene-\nrations", "cross-\nover", "muta-\ntion")
    for heading in (*rates, *short, "\n".join(pictures.label(improved).split())):
        table.add_column(heading, justify="right", no_wrap=True)
    for one in best:
        chosen = [f"{m:z.4f} ± {s:.4f}" for m, s in zip(one.mean, one.sd, strict=True)]
        table.add_row(
            str(one.population),
            str(one.generations),
            f"{one.crossover:g}",
            f"{one.mutation:g}",
            *chosen,
            f"{one.mean_improved:.4f}",
        )
    return table

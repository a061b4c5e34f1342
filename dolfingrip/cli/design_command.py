"""``dolfingrip design``: improve a finger by gradients, under limits that hold."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from dolfingrip.cli.options import Out, Overrides, check_writable, console, one_process
from dolfingrip.cli.simulations import Workers, resumable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dolfingrip.design.gradient.problem import Constraint, Problem
    from dolfingrip.design.gradient.trial import Descent, Trial
    from dolfingrip.files.design import DesignFile
    from dolfingrip.meshes.solid import SolidMesh


def design(
    file: Annotated[Path, typer.Argument(help="TOML: objective, constraints, parameters.")],
    out: Out = Path("out/design"),
    workers: Workers = 1,
    overrides: Overrides = None,
    refine: Annotated[
        bool, typer.Option(help="Solve start and result again on a finer mesh.")
    ] = True,
) -> None:
    """Find the best design by gradients: each step is accepted on finite elements.

    A run that was stopped goes on from OUT/simulations. OUT then holds design.json, design.toml
    (a configuration), finger.stl, steps.csv, and pictures of finger, section and convergence;
    OUT/steps a picture of each accepted design, drawn as it is found.
    """
    one_process("--workers, without mpirun")
    from dolfingrip.design.gradient import run, starts
    from dolfingrip.design.gradient.quantity import GRASP
    from dolfingrip.design.gradient.read import read
    from dolfingrip.jobs.cluster import Where
    from dolfingrip.jobs.pool import Pool

    problem = read(file, dict(overrides or ()))
    check_writable(out)
    screen = console()
    if problem.front is not None:
        _front(problem, out, workers, screen)
        return
    folder = out / run.FOLDER
    begun = time.monotonic()
    screen.print(_asked(problem), soft_wrap=True)
    with resumable(screen, folder), Pool(Where(workers=workers)) as pool:
        compute = run.computed_in(folder, pool)
        every = starts.solve(problem, compute, _Said(screen, problem, out))
        found = every.best(problem)
        wall_s = time.monotonic() - begun
        refined = None
        if refine and problem.objective.experiment != GRASP:
            screen.print("start and result on a finer mesh")
            refined = run.refine(problem, found, compute)
    several = every.facts(problem) if problem.method.starts > 1 else {}
    told = run.facts(problem, found, refined, wall_s, **several)
    run.write(told, found, out)
    _draw(told, found, out)
    _print(told, found, screen)
    screen.print(f"results: {out}", soft_wrap=True)


def _front(problem: Problem, out: Path, workers: int, screen: Console) -> None:
    """Find a front and write ``front.json``, ``front.csv`` and ``front.png``."""
    from dolfingrip.charts import picture
    from dolfingrip.design.gradient import front, run
    from dolfingrip.jobs.cluster import Where
    from dolfingrip.jobs.pool import Pool
    from dolfingrip.report.design import gradient_front

    most, folder = problem.method.simulations, out / run.FOLDER
    begun = time.monotonic()

    def say(done: int, unsure: float, failed: bool) -> None:
        note = "failed" if failed else f"the front is sure to {100 * unsure:.2g} % of its range"
        screen.print(f"{done} of {most} simulations: {note}")

    assert problem.front is not None
    with resumable(screen, folder), Pool(Where(workers=workers)) as pool:
        compute = run.computed_in(folder, pool)
        found = front.FrontFinder(problem, problem.front, compute, say).run()
    told = run.front_facts(problem, found, time.monotonic() - begun)
    run.write_front(told, out)
    picture.write(gradient_front(told), out / "front.png", picture.Look(panel_in=(4.5, 3.8)))
    screen.print(f"results: {out}", soft_wrap=True)


def _asked(problem: Problem) -> str:
    word = "minimise" if problem.sign > 0 else "maximise"
    limits = "".join(f"; {each}" for each in problem.limits)
    return f"{word} {problem.objective}{limits}; {len(problem.variables)} parameters"


STEPS = "steps"
"""Folder with a picture of each accepted design."""


class _Said:
    """Prints a line for each design, and the section of accepted ones, which it also draws."""

    def __init__(self, screen: Console, problem: Problem, out: Path) -> None:
        self._screen, self._problem, self._out = screen, problem, out
        self._start: SolidMesh | None = None
        self._number = 0

    def __call__(self, trial: Trial, limits: Sequence[tuple[Constraint, float]]) -> None:
        from dolfingrip.report.section_text import section_text
        from dolfingrip.report.shape_change import draw_section

        most = self._problem.method.simulations
        self._number += 1
        if trial.failure:
            said = f"failed ({trial.failure.partition(':')[0]}), so the next step is shorter"
        else:
            said = f"{self._problem.objective.name} {trial.objective:.4g}, "
            said += "accepted" if trial.accepted else "not accepted, so the next step is shorter"
            kept = zip(limits, trial.limits, strict=True)
            said += "".join(f"; {limit.quantity.name} {value:.4g}" for (limit, _), value in kept)
        self._screen.print(f"{trial.simulations} of {most} simulations: {said}", soft_wrap=True)
        if trial.accepted:
            self._screen.print(section_text(trial.shape.mesh), end="\n")
            self._start = self._start or trial.shape.mesh
            file = self._out / STEPS / f"{self._number:03d}.png"
            name = self._problem.objective.name
            title = f"{name} {trial.objective:.4g} after {trial.simulations} simulations"
            if draw_section(trial.shape.mesh, self._start, title, file):
                self._screen.print(f"picture: {file}", soft_wrap=True)


def _draw(told: DesignFile, found: Descent, out: Path) -> None:
    from dolfingrip.charts import picture
    from dolfingrip.files.columns import read_csv
    from dolfingrip.report.design import course
    from dolfingrip.report.shape_change import draw_change, write_stl

    start, best = found.start.shape.mesh, found.best.shape.mesh
    draw_change(start, best, ("start", "design"), out)
    write_stl(best, out / "finger.stl")
    charts = course(told, read_csv(out / "steps.csv"))
    picture.write(charts, out / "convergence.png", picture.Look(panel_in=(5.0, 3.8)))


SHOWN = 16
"""Parameters in the table; a free form's numbers are in ``design.json``."""


def _print(told: DesignFile, found: Descent, screen: Console) -> None:
    table = Table(title="Design", box=SIMPLE_HEAD, padding=(0, 1))
    for column in ("", "start", "design", "limit"):
        table.add_column(column, justify="left" if not column else "right", overflow="fold")
    table.add_row(told.of, f"{told.start:.4g}", f"{told.objective:.4g}", "")
    for each in told.constraints:
        limit = f"{each.sense} {each.limit:.4g}"
        table.add_row(each.of, f"{each.start:.4g}", f"{each.value:.4g}", limit)
    own = {k: v for k, v in told.parameters.items() if not k.startswith("form.")}
    for key, one in list(own.items())[:SHOWN]:
        table.add_row(key, f"{one.start:.4g}", f"{one.value:.4g}", f"{one.low:g} to {one.high:g}")
    screen.print(table)
    gain = "" if told.gain is None else f"{100 * told.gain:+.1f} % with "
    screen.print(f"{gain}{told.simulations} simulations: {told.ending}", soft_wrap=True)
    for number, begun in enumerate(told.starts, 1):
        ends = "" if begun.objective is None else f"{begun.start:.4g} to {begun.objective:.4g}, "
        screen.print(f"start {number}: {ends}{begun.ending}", soft_wrap=True)
    if told.differ is not None:
        apart = [f"{key} {low:.4g} to {high:.4g}" for key, (low, high) in told.differ.items()]
        shown = ", ".join(apart[:SHOWN]) or "nothing"
        screen.print(f"differs between the best designs: {shown}", soft_wrap=True)
    refined = told.refined
    if refined is not None and refined.failure:
        screen.print(f"finer mesh: {refined.failure}", style="red", soft_wrap=True)
    elif refined is not None and refined.gain is not None:
        screen.print(
            f"finer mesh: {refined.start:.4g} to {refined.objective:.4g}, "
            f"{100 * refined.gain:+.1f} %",
            soft_wrap=True,
        )

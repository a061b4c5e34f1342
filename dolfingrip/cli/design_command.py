"""``dolfingrip design``: improve a finger by gradients, under limits that hold."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import Screen, console, one_process, resumable
from dolfingrip.cli.settings import DesignSettings
from dolfingrip.design.gradient import curve, front, run, starts
from dolfingrip.design.gradient.descent import Descent, Trial
from dolfingrip.design.gradient.file import GRASP
from dolfingrip.design.gradient.problem import Constraint, Problem
from dolfingrip.design.gradient.read import read
from dolfingrip.experiments.simulate import computed_in
from dolfingrip.files.design import DesignFile, as_shown, named
from dolfingrip.files.table import read_csv
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.report.design import course, gradient_front
from dolfingrip.report.shape_change import draw_change, draw_section, section_text, write_stl
from dolfingrip.report.table import of_rows
from dolfingrip.sections.units import unit


def design(args: DesignSettings) -> None:
    """Find the best design by gradients: each step is accepted on finite elements."""
    one_process("--workers, without mpirun")

    problem = read(args.file, args.overrides)
    screen = console()
    if problem.front is not None:
        _front(problem, args.out, args.workers, screen)
        return
    folder = args.out / run.FOLDER
    begun = time.monotonic()
    screen.say(_asked(problem))
    if back := curve.backwards(problem):
        screen.say(back, style="red")
    if near := curve.forecast(problem):
        screen.say(near)
    with resumable(screen, folder), Pool(Where(workers=args.workers)) as pool:
        compute = computed_in(folder, pool)
        with progress.shown(screen, "simulations", total=problem.method.simulations) as show:
            every = starts.solve(problem, compute, _Said(screen, show, problem, args.out))
        descent = every.best(problem)
        wall_s = time.monotonic() - begun
        refined = None
        if args.refine and problem.objective.experiment != GRASP:
            screen.print("start and result on a finer mesh")
            refined = run.refine(problem, descent, compute)
        if args.fields:
            screen.print("start and result once more, with their fields")
            run.follow(problem, descent, compute, args.out)
    several = every.facts(problem) if problem.method.starts > 1 else {}
    result = run.facts(problem, descent, refined, wall_s, **several)
    run.write(result, descent, args.out)
    _draw(result, descent, args.out)
    _print(result.shown, descent, screen)
    screen.say(f"results: {args.out}")


def _front(problem: Problem, out: Path, workers: int, screen: Screen) -> None:
    """Find a front and write ``front.json``, ``front.csv`` and ``front.png``."""

    most, folder = problem.method.simulations, out / run.FOLDER

    def say(done: int, unsure: float, failed: bool) -> None:
        note = "failed" if failed else f"the front is sure to {100 * unsure:.2g} % of its range"
        screen.print(f"{done} of {most} simulations: {note}")
        show(done, most)

    assert problem.front is not None
    with resumable(screen, folder), Pool(Where(workers=workers)) as pool:
        compute = computed_in(folder, pool)
        with progress.shown(screen, "simulations", total=most) as show:
            result = front.FrontFinder(problem, problem.front, compute, say).run()
    if result.failed:
        unknown = f"{result.failed} of {result.simulations} simulations failed"
        screen.say(f"{unknown}: whether those designs are better is not known")
    run.write_front(result, out)
    picture.write(gradient_front(result), out / "front.png", picture.Look(panel_in=(4.5, 3.8)))
    screen.say(f"results: {out}")


def _asked(problem: Problem) -> str:
    word = "minimise" if problem.sign > 0 else "maximise"
    limits = "".join(f"; {limit}" for limit in problem.limits)
    return f"{word} {named(str(problem.objective))}{limits}; {len(problem.variables)} parameters"


STEPS = "steps"
"""Folder with a picture of each accepted design."""


class _Said:
    """Prints a line for each design, and the section of accepted ones, which it also draws."""

    def __init__(self, screen: Screen, show: progress.Show, problem: Problem, out: Path) -> None:
        self._screen, self._show, self._problem, self._out = screen, show, problem, out
        self._start: SolidMesh | None = None
        self._number = 0

    def __call__(self, trial: Trial, limits: Sequence[tuple[Constraint, float]]) -> None:

        most, quantity = self._problem.method.simulations, self._problem.objective.name
        name, value = named(quantity), as_shown(quantity, trial.objective)
        self._number += 1
        if trial.failure:
            said = f"failed ({trial.failure.partition(':')[0]}), so the next step is shorter"
        else:
            said = f"{name} {value:.4g}, "
            said += "accepted" if trial.accepted else "not accepted, so the next step is shorter"
            kept = zip(limits, trial.limits, strict=True)
            said += "".join(f"; {limit.quantity.name} {value:.4g}" for (limit, _), value in kept)
        self._screen.say(f"{trial.simulations} of {most} simulations: {said}")
        self._show(trial.simulations, most)
        if trial.accepted:
            self._screen.print(section_text(trial.shape.mesh), end="\n")
            self._start = self._start or trial.shape.mesh
            file = self._out / STEPS / f"{self._number:03d}.png"
            title = f"{name} {value:.4g} after {trial.simulations} simulations"
            if draw_section(trial.shape.mesh, self._start, title, file):
                self._screen.say(f"picture: {file}")


def _draw(result: DesignFile, descent: Descent, out: Path) -> None:

    start, best = descent.start.shape.mesh, descent.best.shape.mesh
    draw_change(start, best, ("start", "design"), out)
    write_stl(best, out / "finger.stl")
    charts = course(result, read_csv(out / "steps.csv"))
    picture.write(charts, out / "convergence.png", picture.Look(panel_in=(5.0, 3.8)))


SHOWN = 16
"""Parameters in the table; a free form's numbers are in ``design.json``."""


def _print(result: DesignFile, descent: Descent, screen: Screen) -> None:
    rows = [(result.of, f"{result.start:.4g}", f"{result.objective:.4g}", "")]
    rows += [
        (bound.of, f"{bound.start:.4g}", f"{bound.value:.4g}", f"{bound.sense} {bound.limit:.4g}")
        for bound in result.constraints
    ]
    parameters = {k: v for k, v in result.parameters.items() if not k.startswith("form.")}
    rows += [
        (key, f"{one.start:.4g}", f"{one.value:.4g}", f"{one.low:g} to {one.high:g}")
        for key, one in list(parameters.items())[:SHOWN]
    ]
    headings = ("Quantity", "Start", "Design", "Limit")
    screen.print(of_rows(headings, rows, "Design", left=headings[:1]))
    gain = "" if result.gain is None else f"{100 * result.gain:+.1f} % with "
    screen.say(f"{gain}{result.simulations} simulations: {result.ending}")
    if (near := result.matched) is not None:
        screen.say(f"rms distance from the curve: {near.start_rms_mm:.3g} to {near.rms_mm:.3g} mm")
        for key, price in list(near.stops_mm_per_unit.items())[:SHOWN]:
            one = result.parameters[key]
            said = f"{key} = {one.value:.4g} (bounds {one.low:g} and {one.high:g})"
            nearer = f"{price:.2g} mm nearer for each {unit(key) or 'unit'} beyond it"
            screen.say(f"stopped by {said}: {nearer}")
        if near.tied:
            count = f"{len(near.tied)} of {len(result.parameters)}"
            screen.say(f"tied: {count} parameters may be others where the rest makes up for it:")
        for key, others in list(near.tied.items())[:SHOWN]:
            made_up = (f"{other} {by:+.2g} {unit(other)}" for other, by in others.items())
            screen.say(f"{key} +1 {unit(key)}: {', '.join(made_up) or 'hardly felt'}")
    for number, begun in enumerate(result.starts, 1):
        ends = ""
        if begun.objective is not None:
            ends = f"{result.quantity} {begun.start:.4g} to {begun.objective:.4g}, "
        screen.say(f"start {number}: {ends}{begun.ending}")
    if result.differ is not None:
        apart = [f"{key} {low:.4g} to {high:.4g}" for key, (low, high) in result.differ.items()]
        shown = ", ".join(apart[:SHOWN]) or "nothing"
        screen.say(f"differs between the best designs: {shown}")
    refined = result.refined
    if refined is not None and refined.failure:
        screen.say(f"finer mesh: {refined.failure}", style="red")
    elif refined is not None and refined.gain is not None:
        screen.say(
            f"finer mesh: {result.quantity} {refined.start:.4g} to {refined.objective:.4g}, "
            f"{100 * refined.gain:+.1f} %"
        )

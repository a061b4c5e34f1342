"""A problem from start to files: its jobs in a folder, the descent, a finer mesh, the results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from dolfingrip import config as configuration
from dolfingrip.channels import PRESSURE
from dolfingrip.config import Config
from dolfingrip.design.gradient import curve
from dolfingrip.design.gradient.descent import Descent, Trial
from dolfingrip.design.gradient.evaluation import DesignSimulations
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.quantities.grasp import GRASP
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import Compute
from dolfingrip.experiments.simulate import compute as compute_here
from dolfingrip.files import table, whole
from dolfingrip.files.design import (
    MARKERS,
    RUNS,
    ConditionObjective,
    DesignConstraint,
    DesignFile,
    DesignParameter,
    RefinedDesign,
)
from dolfingrip.files.front import FrontFile
from dolfingrip.files.run import RunFile

FOLDER: Final = "simulations"
"""Folder in ``--out`` that holds what was computed."""

REFINED: Final = 2
"""How often each cell is divided along each axis for the finer mesh."""


NOTHING: Final = 1e-6
"""Part of the best objective below which the start's has no gain that means anything."""


def refine(problem: Problem, found: Descent, compute: Compute) -> RefinedDesign:
    """Solve start and best design again on a finer mesh, without gradients.

    Args:
        problem: what was asked.
        found: how it was solved.
        compute: what computes jobs.

    Returns:
        Objective and limits there, or why they are not known.
    """

    def finer(config: Config) -> Config:
        if config.hexahedra or config.mesh.file is not None:
            return config.changed(mesh={"refine": REFINED * config.mesh.refine})
        sizes = config.mesh.tetrahedra_mm()
        return config.changed(
            mesh={"size_mm": sizes[0] / REFINED, "edge_size_mm": sizes[1] / REFINED}
        )

    simulations = DesignSimulations(problem, compute)
    values: list[float] = []
    limits: dict[str, list[float]] = {}
    count, failure = 0, ""
    for trial in (found.start, found.best):
        solved = simulations.at(trial.values, gradients=False, finer=finer)
        count += solved.simulations
        failure = failure or solved.failure
        if failure:
            values.append(float("nan"))
            continue
        each = [by.get(problem.objective) for by in solved.by_condition]
        worst = [problem.sign * one.value for one in each if one is not None]
        values.append(problem.sign * max(worst) if worst else trial.objective)
        for limit in problem.limits:
            if limit.quantity.experiment is not None:
                every = [limit.sign * by[limit.quantity].value for by in solved.by_condition]
                limits.setdefault(str(limit), []).append(limit.sign * max(every))
    start, best = map(_known, values)
    return RefinedDesign(
        objective=best,
        start=start,
        gain=best / start - 1 if start and best is not None else None,
        constraints={name: tuple(each) for name, each in limits.items()},
        failure=failure,
        simulations=count,
    )


def follow(problem: Problem, found: Descent, compute: Compute, out: Path) -> None:
    """Run start and best design along their load paths, and write results with fields.

    Both are on the mesh of the start. A grasp, and numbers of the unloaded shape, have free bending
    in their place.

    Args:
        problem: what was asked.
        found: how it was solved.
        compute: what computes jobs.
        out: folder, in which each result has its folder of :data:`RUNS`.

    Raises:
        WriteError: one line.
    """
    asked, changes = problem.objective, dict[str, dict[str, Any]]()
    own = asked.experiment not in (None, GRASP)
    if asked.where == PRESSURE.name:
        changes["experiment"] = {"max_pressure_kPa": max(asked.values)}
    if problem.parts:
        changes["camera"] = {"markers": MARKERS}
    requests = [
        Request.of(
            str(asked.experiment) if own else "bending", trial.shape.config.changed(**changes),
            made_for=found.start.shape.config, fields=(out / name).resolve(),
        )
        for name, trial in zip(RUNS, (found.start, found.best), strict=True)
    ]  # fmt: skip
    compute(requests)
    for each, name in zip(requests, RUNS, strict=True):
        config = each.config.model_dump(mode="json", exclude_none=True)
        # the store may have an answer whose folder is gone, or another problem's by now
        if not RunFile.is_in(out / name) or RunFile.read(out / name).config != config:
            compute_here(each)


def facts(
    problem: Problem, found: Descent, refined: RefinedDesign | None, wall_s: float, **several: Any
) -> DesignFile:
    """Make the ``design.json`` of a problem.

    Args:
        problem: what was asked.
        found: how it was solved.
        refined: start and design on a finer mesh; None: they were not solved there.
        wall_s: time that it took (s).
        several: ``starts`` and ``differ``, if there were several starts.

    Returns:
        The content of the file.
    """
    word = "minimise" if problem.sign > 0 else "maximise"
    start, best = found.start, found.best
    from_nothing = abs(start.objective) < NOTHING * abs(best.objective)
    return DesignFile(
        of=f"{word} {problem.objective}",
        quantity=problem.objective.name,
        objective=best.objective,
        start=start.objective,
        gain=None if from_nothing else best.objective / start.objective - 1,
        constraints=tuple(
            DesignConstraint(
                of=str(limit.quantity),
                sense="at most" if limit.sign > 0 else "at least",
                limit=value,
                start=start.limits[i],
                value=best.limits[i],
                kept=limit.sign * (value - best.limits[i]) >= -1e-4 * max(abs(value), 1e-9),
            )
            for i, (limit, value) in enumerate(found.limits)
        ),
        simulations=found.simulations,
        designs=len(found.trials),
        failed_designs=sum(bool(each.failure) for each in found.trials),
        ending=found.ending,
        wall_s=round(wall_s, 1),
        simulations_s=round(found.seconds, 1),
        conditions=tuple(each.name for each in problem.conditions),
        by_condition=_by_condition(problem, found),
        parameters={
            each.key: DesignParameter(
                start=float(start.values[i]),
                value=float(best.values[i]),
                low=each.low,
                high=each.high,
            )
            for i, each in enumerate(problem.variables)
        },
        refined=refined,
        matched=curve.matched(problem, found),
        **several,
    )


def _by_condition(problem: Problem, found: Descent) -> tuple[ConditionObjective, ...]:
    """The objective of start and best design under each condition."""
    if len(found.best.signed) != len(problem.conditions):  # of the unloaded shape
        return ()
    return tuple(
        ConditionObjective(
            condition=each.name,
            start=problem.sign * float(found.start.signed[i]),
            objective=problem.sign * float(found.best.signed[i]),
        )
        for i, each in enumerate(problem.conditions)
    )


def _known(value: float) -> float | None:
    return None if value != value else value


def write(told: DesignFile, found: Descent, out: Path) -> None:
    """Write ``design.json``, ``steps.csv`` and ``design.toml``.

    Args:
        told: content of the first.
        found: the descent.
        out: folder.

    Raises:
        WriteError: one line.
    """
    told.write(out)
    table.write(out / "steps.csv", [_step(each, found) for each in found.trials])
    whole.write(out / "design.toml", configuration.dumps(found.best.shape.config))


def write_front(told: FrontFile, out: Path) -> None:
    """Write ``front.json`` and ``front.csv``.

    Args:
        told: the front.
        out: folder.

    Raises:
        WriteError: one line.
    """
    told.write(out)
    limited, improved = told.objectives
    rows = [
        {
            f"{limited.title} {limited.sense}": each.limit,
            improved.name: each.mean,
            "standard_deviation": each.deviation,
            **{
                f"{key}{word}": values[i]
                for i, word in enumerate(("", " from", " to"))
                for key, values in each.inputs.items()
            },
        }
        for each in told.levels
    ]
    table.write(out / "front.csv", rows)


def _step(trial: Trial, found: Descent) -> dict[str, object]:
    values: Sequence[float | None] = trial.limits or [None] * len(found.limits)
    return {
        "simulations": trial.simulations,
        "accepted": trial.accepted,
        "objective": None if trial.failure else trial.objective,
        **{str(limit): value for (limit, _), value in zip(found.limits, values, strict=True)},
        "radius": trial.radius,
        "expected_gain": trial.expected,
        "failure": trial.failure,
    }

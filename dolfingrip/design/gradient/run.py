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


def refine(problem: Problem, descent: Descent, compute: Compute) -> RefinedDesign:
    """Solve start and best design again on a finer mesh, without gradients.

    Args:
        problem: what was asked.
        descent: how it was solved.
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
    for trial in (descent.start, descent.best):
        solved = simulations.at(trial.values, gradients=False, finer=finer)
        count += solved.simulations
        failure = failure or solved.failure
        if failure:
            values.append(float("nan"))
            continue
        objectives = [by.get(problem.objective) for by in solved.by_condition]
        worst = [problem.sign * one.value for one in objectives if one is not None]
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
        constraints={name: tuple(pair) for name, pair in limits.items()},
        failure=failure,
        simulations=count,
    )


def follow(problem: Problem, descent: Descent, compute: Compute, out: Path) -> None:
    """Run start and best design along their load paths, and write results with fields.

    Both are on the mesh of the start. A grasp, and numbers of the unloaded shape, have free bending
    in their place.

    Args:
        problem: what was asked.
        descent: how it was solved.
        compute: what computes jobs.
        out: folder, in which each result has its folder of :data:`RUNS`.

    Raises:
        WriteError: one line.
    """
    goal, changes = problem.objective, dict[str, dict[str, Any]]()
    loaded = goal.experiment not in (None, GRASP)
    if goal.where == PRESSURE.name:
        changes["experiment"] = {"max_pressure_kPa": max(goal.values)}
    if problem.parts:
        changes["camera"] = {"markers": MARKERS}
    requests = [
        Request.of(
            str(goal.experiment) if loaded else "bending", trial.shape.config.changed(**changes),
            made_for=descent.start.shape.config, fields=(out / name).resolve(),
        )
        for name, trial in zip(RUNS, (descent.start, descent.best), strict=True)
    ]  # fmt: skip
    compute(requests)
    for request, name in zip(requests, RUNS, strict=True):
        config = request.config.model_dump(mode="json", exclude_none=True)
        # the store may have an answer whose folder is gone, or another problem's by now
        if not RunFile.is_in(out / name) or RunFile.read(out / name).config != config:
            compute_here(request)


def facts(
    problem: Problem, descent: Descent, refined: RefinedDesign | None, wall_s: float, **several: Any
) -> DesignFile:
    """Make the ``design.json`` of a problem.

    Args:
        problem: what was asked.
        descent: how it was solved.
        refined: start and design on a finer mesh; None: they were not solved there.
        wall_s: time that it took (s).
        several: ``starts`` and ``differ``, if there were several starts.

    Returns:
        The content of the file.
    """
    word = "minimise" if problem.sign > 0 else "maximise"
    start, best = descent.start, descent.best
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
            for i, (limit, value) in enumerate(descent.limits)
        ),
        simulations=descent.simulations,
        designs=len(descent.trials),
        failed_designs=sum(bool(trial.failure) for trial in descent.trials),
        ending=descent.ending,
        wall_s=round(wall_s, 1),
        simulations_s=round(descent.seconds, 1),
        conditions=tuple(condition.name for condition in problem.conditions),
        by_condition=_by_condition(problem, descent),
        parameters={
            variable.key: DesignParameter(
                start=float(start.values[i]),
                value=float(best.values[i]),
                low=variable.low,
                high=variable.high,
            )
            for i, variable in enumerate(problem.variables)
        },
        refined=refined,
        matched=curve.matched(problem, descent),
        **several,
    )


def _by_condition(problem: Problem, descent: Descent) -> tuple[ConditionObjective, ...]:
    """The objective of start and best design under each condition."""
    if len(descent.best.signed) != len(problem.conditions):  # of the unloaded shape
        return ()
    return tuple(
        ConditionObjective(
            condition=condition.name,
            start=problem.sign * float(descent.start.signed[i]),
            objective=problem.sign * float(descent.best.signed[i]),
        )
        for i, condition in enumerate(problem.conditions)
    )


def _known(value: float) -> float | None:
    return None if value != value else value


def write(design: DesignFile, descent: Descent, out: Path) -> None:
    """Write ``design.json``, ``steps.csv`` and ``design.toml``.

    Args:
        design: content of the first.
        descent: the descent.
        out: folder.

    Raises:
        WriteError: one line.
    """
    design.write(out)
    table.write(out / "steps.csv", [_step(trial, descent) for trial in descent.trials])
    whole.write(out / "design.toml", configuration.dumps(descent.best.shape.config))


def write_front(front: FrontFile, out: Path) -> None:
    """Write ``front.json`` and ``front.csv``.

    Args:
        front: the front.
        out: folder.

    Raises:
        WriteError: one line.
    """
    front.write(out)
    limited, improved = front.objectives
    rows = [
        {
            f"{limited.title} {limited.sense}": level.limit,
            improved.name: level.mean,
            "standard_deviation": level.deviation,
            **{
                f"{key}{word}": values[i]
                for i, word in enumerate(("", " from", " to"))
                for key, values in level.inputs.items()
            },
        }
        for level in front.levels
    ]
    table.write(out / "front.csv", rows)


def _step(trial: Trial, descent: Descent) -> dict[str, object]:
    values: Sequence[float | None] = trial.limits or [None] * len(descent.limits)
    return {
        "simulations": trial.simulations,
        "accepted": trial.accepted,
        "objective": None if trial.failure else trial.objective,
        **{str(limit): value for (limit, _), value in zip(descent.limits, values, strict=True)},
        "radius": trial.radius,
        "expected_gain": trial.expected,
        "failure": trial.failure,
    }

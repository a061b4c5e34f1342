"""A problem from start to files: its jobs in a folder, the descent, a finer mesh, the results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.design.gradient.evaluation import Compute, Simulations
from dolfingrip.design.gradient.front import Front
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.trial import Descent, Trial
from dolfingrip.experiments.simulate import simulate
from dolfingrip.files import table, whole
from dolfingrip.jobs.pool import Pool

FOLDER: Final = "simulations"
"""Folder in ``--out`` that holds what was computed."""

REFINED: Final = 2
"""How often each cell is divided along each axis for the finer mesh."""


NOTHING: Final = 1e-6
"""Part of the best objective below which the start's has no gain that means anything."""


@dataclass(slots=True)
class Refined:
    """Start and best design on a finer mesh.

    Attributes:
        start, best: objective.
        failure: class and sentence; "" if both were solved.
        simulations: load paths.
        limits: values of each simulated limit's quantity at start and best, by the limit's text.
    """

    start: float
    best: float
    failure: str
    simulations: int
    limits: dict[str, list[float]]

    @property
    def gain(self) -> float:
        """Change of the objective as a part of the start's."""
        return self.best / self.start - 1


def computed_in(folder: Path, pool: Pool) -> Compute:
    """Return what computes requests and keeps their answers in a folder.

    Args:
        folder: of the store; what it has is not computed again.
        pool: workers.

    Returns:
        A function from requests to answers.
    """
    return lambda requests: simulate(requests, folder, pool)


def refine(problem: Problem, found: Descent, compute: Compute) -> Refined:
    """Solve start and best design again on a finer mesh, without gradients."""

    def finer(config: Config) -> Config:
        if config.hexahedra:
            return config.changed(mesh={"refine": REFINED * config.mesh.refine})
        sizes = config.mesh.tetrahedra_mm()
        return config.changed(
            mesh={"size_mm": sizes[0] / REFINED, "edge_size_mm": sizes[1] / REFINED}
        )

    simulations = Simulations(problem, compute)
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
    return Refined(values[0], values[1], failure, count, limits)


def facts(
    problem: Problem, found: Descent, refined: Refined | None, wall_s: float
) -> dict[str, Any]:
    """Contents of ``design.json``."""
    word = "minimise" if problem.sign > 0 else "maximise"
    start, best = found.start, found.best
    from_nothing = abs(start.objective) < NOTHING * abs(best.objective)
    gain = None if from_nothing else best.objective / start.objective - 1
    limits = []
    for i, (limit, value) in enumerate(found.limits):
        left = limit.sign * (value - best.limits[i])
        limits.append(
            {
                "of": str(limit.quantity),
                "sense": "at most" if limit.sign > 0 else "at least",
                "limit": value,
                "start": start.limits[i],
                "value": best.limits[i],
                "kept": left >= -1e-4 * max(abs(value), 1e-9),
            }
        )
    parameters = {
        each.key: {
            "start": float(start.values[i]),
            "value": float(best.values[i]),
            "low": each.low,
            "high": each.high,
        }
        for i, each in enumerate(problem.variables)
    }
    told: dict[str, Any] = {
        "of": f"{word} {problem.objective}",
        "objective": best.objective,
        "start": start.objective,
        "gain": gain,
        "constraints": limits,
        "simulations": found.simulations,
        "designs": len(found.trials),
        "failed_designs": sum(bool(each.failure) for each in found.trials),
        "ending": found.ending,
        "wall_s": round(wall_s, 1),
        "simulations_s": round(found.seconds, 1),
        "conditions": [each.name for each in problem.conditions],
        "by_condition": _by_condition(problem, found),
        "parameters": parameters,
    }
    if refined is not None:
        told["refined"] = {
            "objective": refined.best,
            "start": refined.start,
            "gain": None if refined.failure or not refined.start else refined.gain,
            "constraints": refined.limits,
            "failure": refined.failure,
            "simulations": refined.simulations,
        }
    return _plain(told)


def _by_condition(problem: Problem, found: Descent) -> list[dict[str, Any]]:
    """The objective of start and best design under each condition."""
    if len(found.best.signed) != len(problem.conditions):  # of the unloaded shape
        return []
    return [
        {
            "condition": each.name,
            "start": problem.sign * float(found.start.signed[i]),
            "objective": problem.sign * float(found.best.signed[i]),
        }
        for i, each in enumerate(problem.conditions)
    ]


def _plain(value: Any) -> Any:
    """Plain data without numbers that JSON lacks."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and value != value else value


def write(told: dict[str, Any], found: Descent, out: Path) -> None:
    """Write ``design.json``, ``steps.csv`` and ``design.toml``."""
    text = json.dumps(told, indent=2, ensure_ascii=False, allow_nan=False)
    whole.write(out / "design.json", text + "\n")
    table.write(out / "steps.csv", [_step(each, found) for each in found.trials])
    whole.write(out / "design.toml", configuration.dumps(found.best.shape.config))


def write_front(problem: Problem, found: Front, wall_s: float, out: Path) -> None:
    """Write ``front.json`` and ``front.csv``."""
    keys = [each.key for each in problem.variables]
    table.write(
        out / "front.csv",
        [
            {
                f"{found.name} at most": float(limit),
                problem.objective.name: float(mean),
                "standard_deviation": float(deviation),
                **dict(zip(keys, map(float, found.values[i]), strict=True)),
                **{
                    f"{key} from": float(value)
                    for key, value in zip(keys, found.lowest[i], strict=True)
                },
                **{
                    f"{key} to": float(value)
                    for key, value in zip(keys, found.highest[i], strict=True)
                },
            }
            for i, (limit, mean, deviation) in enumerate(
                zip(found.limit, found.mean, found.deviation, strict=True)
            )
        ],
    )
    told = {
        "of": str(problem.objective),
        "against": found.name,
        "simulations": len(found.objective) + found.failed,
        "failed": found.failed,
        "hypervolumes": found.areas,
        "unsure": found.unsure,
        "wall_s": round(wall_s, 1),
        "simulated": [
            {
                **dict(zip(keys, map(float, values), strict=True)),
                found.name: float(against),
                problem.objective.name: float(objective),
            }
            for values, against, objective in zip(
                found.simulated, found.against, found.objective, strict=True
            )
        ],
    }
    text = json.dumps(_plain(told), indent=2, ensure_ascii=False, allow_nan=False)
    whole.write(out / "front.json", text + "\n")


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

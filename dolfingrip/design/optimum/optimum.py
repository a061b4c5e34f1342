"""An optimisation: the front of a surrogate, choices along it, and finite elements there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dolfingrip.config import Config
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import OBJECTIVE, Plan, quantities
from dolfingrip.design.optimum import pareto
from dolfingrip.design.optimum.pareto import Matrix, NSGA2Settings, TradeOff, Vector
from dolfingrip.design.surrogate.surrogate import Surrogate
from dolfingrip.files import table
from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.optimum import ChosenDesign, FrontDesign, OptimumFile, SurrogateError
from dolfingrip.files.surrogate import PREFIX
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.version import versions_of

Outputs = dict[str, float]


class Recomputed(NamedTuple):
    """A design by finite elements.

    Attributes:
        fem: outputs by name; None where they failed.
        failure: why, in one sentence; "" where they did not.
    """

    fem: Outputs | None
    failure: str = ""


Evaluate = Callable[[Sequence[dict[str, float]]], list[Recomputed]]
"""From designs (inputs by name) to what finite elements give for each."""


def find(
    surrogate: Surrogate,
    objectives: tuple[NamedObjective, NamedObjective],
    limits: Sequence[float],
    settings: NSGA2Settings,
    progress: Callable[[int], None] | None = None,
) -> OptimumFile:
    """Find the front within the surrogate's range, and choose on it.

    Args:
        surrogate: with both objectives among its outputs.
        objectives: the limited one, the improved one.
        limits: of the first objective, to choose by.
        settings: of NSGA-II.
        progress: called with the generations done.

    Returns:
        The front, and the designs that are worth computing again.

    Raises:
        ConfigError: one line, where the surrogate lacks an objective.
    """
    trade_off = TradeOff.of(surrogate, objectives)
    front = pareto.fronts(trade_off, settings, progress=progress)[settings.generations]

    def selected(design: Vector, role: str, limit: float | None = None) -> ChosenDesign:
        ((inputs, outputs),) = _named(surrogate, design[None, :])
        return ChosenDesign(role=role, limit=limit, inputs=inputs, surrogate=outputs)

    chosen, polished, missed = [], [], []
    for limit in limits:
        place = front.choose(limit)
        if place is None:
            missed.append(limit)
            continue
        chosen.append(selected(front.designs[place], "chosen", limit))
        better = pareto.polish(trade_off, front.designs[place], limit)
        if better is not None:
            polished.append(selected(better[0], "polished", limit))
    zero = np.zeros(len(surrogate.input_names))  # which a morph leaves as it is
    inside = (trade_off.low <= zero).all() and (zero <= trade_off.high).all()
    morphs = all(name.startswith("morph.") for name in surrogate.input_names)
    original = [selected(zero, "original")] if inside and morphs else []
    return OptimumFile(
        objectives=objectives,
        settings=asdict(settings),
        surrogate_sha256=surrogate.sha256(),
        front=tuple(
            FrontDesign(inputs=inputs, surrogate=outputs)
            for inputs, outputs in _named(surrogate, front.designs)
        ),
        limits_below_the_front=tuple(missed),
        designs=(*chosen, *original, *polished),
        versions=versions_of("numpy", "pymoo", "moocore", "torch"),
    )


def _named(surrogate: Surrogate, designs: Matrix) -> list[tuple[dict[str, float], Outputs]]:
    """Inputs and the surrogate's outputs of designs, by name."""
    return [
        (
            dict(zip(surrogate.input_names, map(float, inputs), strict=True)),
            dict(zip(surrogate.output_names, map(float, outputs), strict=True)),
        )
        for inputs, outputs in zip(designs, surrogate.predict(designs, warn=False), strict=True)
    ]


def evaluator(
    base: Config,
    outputs: Sequence[str],
    out: Path,
    where: Where,
    *,
    objective: str = OBJECTIVE,
    progress: Progress = silent,
) -> Evaluate:
    """Compute designs by a campaign; what it already holds is not computed again.

    Args:
        base: configuration that the inputs are put into.
        outputs: quantities wanted.
        out: folder of the campaign.
        where: workers.
        objective: import path of what computes a design.
        progress: called with each answer stored.

    Returns:
        A function from designs to what finite elements give for them.

    Raises:
        ConfigError: one line, where a quantity cannot be computed.
    """
    wanted = quantities(outputs, objective)

    def plan(*designs: dict[str, float]) -> Plan:
        return Plan(base, tuple(designs[0]), tuple(map(dict, designs)), wanted, objective)

    def evaluate(designs: Sequence[dict[str, float]]) -> list[Recomputed]:
        campaign.run(plan(*designs), out, where, progress=progress)
        rows = campaign.read(out).by_key()
        made = [rows[plan(design).designs()[0].key] for design in designs]
        reasons = ["" if one.outputs else one.failure or "not computed" for one in made]
        return [Recomputed(one.outputs, why) for one, why in zip(made, reasons, strict=True)]

    return evaluate


def resolve(optimum: OptimumFile, along: int, evaluate: Evaluate) -> OptimumFile:
    """Compute the chosen designs and points along the front by finite elements.

    Args:
        optimum: front and choices.
        along: number of points along the front, evenly far apart.
        evaluate: computes designs, each once whatever it is wanted for.

    Returns:
        The same with what finite elements gave, and with the surrogate's error along the front.
    """
    values = np.array([[p.surrogate[o.title] for o in optimum.objectives] for p in optimum.front])
    places = {int(i) for i in pareto.spread(values, along)} if along else set()
    inputs = [chosen.inputs for chosen in optimum.designs]
    inputs += [optimum.front[i].inputs for i in sorted(places)]
    distinct = list({tuple(variables.items()): variables for variables in inputs}.values())
    solved = {
        tuple(design.items()): answer
        for design, answer in zip(distinct, evaluate(distinct), strict=True)
    }
    front = tuple(
        p.model_copy(update=solved[tuple(p.inputs.items())]._asdict()) if i in places else p
        for i, p in enumerate(optimum.front)
    )
    designs = [
        d.model_copy(update={**solved[tuple(d.inputs.items())]._asdict(), "resolved": True})
        for d in optimum.designs
    ]
    first, second = optimum.objectives
    references = [_output(chosen, second) for chosen in designs if chosen.role == "original"]
    for place, chosen in enumerate(designs):
        limited, improved = _output(chosen, first), _output(chosen, second)
        update: dict[str, Any] = {}
        if chosen.limit is not None and limited is not None:
            update["within_limit"] = first.sign * limited <= first.sign * chosen.limit
        if references and references[0] and improved is not None:
            update["gain"] = improved / references[0] - 1
        designs[place] = chosen.model_copy(update=update)
    errors = {name: _error(front, name) for name in (front[0].surrogate if front else ())}
    return optimum.model_copy(
        update={
            "front": front,
            "designs": tuple(designs),
            "surrogate_error_on_front": {name: e for name, e in errors.items() if e is not None},
        }
    )


def _output(design: ChosenDesign, of: NamedObjective) -> float | None:
    return None if design.fem is None else design.fem.get(of.title)


def _error(front: Sequence[FrontDesign], name: str) -> SurrogateError | None:
    """The surrogate's error of one output where finite elements could compute it."""
    pairs = [(e.surrogate[name], e.fem[name]) for e in front if e.fem is not None]
    if not pairs:
        return None
    predicted, computed = np.array(pairs).T
    miss = predicted - computed
    rms = float(np.sqrt(np.mean(miss**2)))
    return SurrogateError(
        designs=len(pairs),
        rms=rms,
        largest=float(np.abs(miss).max()),
        relative=rms / float(np.abs(computed).mean()),
    )


def write_front(optimum: OptimumFile, out: Path) -> None:
    """Write ``front.csv``: the designs of the front and the surrogate's outputs.

    Args:
        optimum: whose front it is.
        out: folder.

    Raises:
        WriteError: one line.
    """
    table.write(
        out / "front.csv", [{**e.inputs, **_prefixed(PREFIX, e.surrogate)} for e in optimum.front]
    )


def write(optimum: OptimumFile, out: Path) -> None:
    """Write ``optimum.json`` and, where designs were computed again, ``resolved.csv``.

    Args:
        optimum: front and choices.
        out: folder.

    Raises:
        WriteError: one line.
    """
    again: list[ChosenDesign | FrontDesign] = [d for d in optimum.designs if d.resolved]
    again += [d for d in optimum.front if d.fem is not None or d.failure]
    rows: list[dict[str, Any]] = [
        {
            "role": getattr(design, "role", "front"),
            "limit": getattr(design, "limit", None),
            **design.inputs,
            **_prefixed(PREFIX, design.surrogate),
            **_prefixed("fem.", design.fem or {}),
            "status": "failed" if design.fem is None else "done",
            "failure": design.failure or None,
        }
        for design in again
    ]
    if rows:
        full = max(rows, key=len)  # a failed design lacks numbers
        table.write(out / "resolved.csv", rows, list(full))
    optimum.write(out)


def _prefixed(prefix: str, values: Mapping[str, Any]) -> dict[str, Any]:
    return {prefix + name: value for name, value in values.items()}

"""An optimisation as files: ``front.csv``, ``resolved.csv`` and ``optimum.json``."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib import metadata
from pathlib import Path

import dolfingrip
from dolfingrip.channels import FORCE
from dolfingrip.design.optimum import resolve
from dolfingrip.design.optimum.optimum import Optimum
from dolfingrip.design.optimum.pareto import COG
from dolfingrip.design.optimum.resolve import FailedSolve, Resolved
from dolfingrip.files import table
from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.optimum import ChosenDesign, FrontDesign, OptimumFile, SurrogateError
from dolfingrip.files.surrogate import PREFIX
from dolfingrip.sections.units import unit

SENSES = {COG: "at most", FORCE.name: "maximise"}
"""The objectives of the front, and what is done with each."""


def front(optimum: Optimum, resolved: Sequence[Resolved] = ()) -> list[FrontDesign]:
    """List the designs of a front with the surrogate's outputs.

    Args:
        optimum: whose front it is.
        resolved: designs that were computed again.

    Returns:
        A design for each of its points.
    """
    surrogate = optimum.surrogate
    predicted = surrogate.predict(optimum.front.designs, warn=False)
    again = {
        tuple(each.candidate.inputs.values()): each.computed
        for each in resolved
        if each.candidate.role == "front" and not isinstance(each.computed, FailedSolve)
    }
    return [
        FrontDesign(
            inputs=dict(zip(surrogate.input_names, map(float, x), strict=True)),
            fem=again.get(tuple(map(float, x))),
            surrogate=dict(zip(surrogate.output_names, map(float, y), strict=True)),
        )
        for x, y in zip(optimum.front.designs, predicted, strict=True)
    ]


def write_front(optimum: Optimum, out: Path) -> None:
    """Write ``front.csv``: the designs of the front and the surrogate's outputs.

    Args:
        optimum: whose front it is.
        out: folder.

    Raises:
        WriteError: one line.
    """
    table.write(
        out / "front.csv",
        [
            {**each.inputs, **{PREFIX + name: value for name, value in each.surrogate.items()}}
            for each in front(optimum)
        ],
    )


def write(optimum: Optimum, resolved: Sequence[Resolved], out: Path) -> OptimumFile:
    """Write ``optimum.json`` and, where there is one, ``resolved.csv``.

    Args:
        optimum: the front and its choices.
        resolved: those that were computed again.
        out: folder.

    Returns:
        Content of the JSON.

    Raises:
        WriteError: one line.
    """
    if resolved:
        table.write(out / "resolved.csv", resolve.rows(resolved))
    errors = resolve.errors(resolved)
    first, second = (
        NamedObjective(name=name, unit=unit(name), sense=sense) for name, sense in SENSES.items()
    )
    found = OptimumFile(
        objectives=(first, second),
        settings=asdict(optimum.settings),
        surrogate_sha256=optimum.surrogate.sha256(),
        front=tuple(front(optimum, resolved)),
        limits_below_the_front=tuple(optimum.missed),
        designs=_designs(optimum, resolved),
        surrogate_error_on_front={n: SurrogateError.model_validate(e) for n, e in errors.items()},
        versions={
            "dolfingrip": dolfingrip.__version__,
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in ("numpy", "pymoo", "moocore", "torch")},
        },
    )
    found.write(out)
    return found


def _designs(optimum: Optimum, resolved: Sequence[Resolved]) -> tuple[ChosenDesign, ...]:
    known = {id(one.candidate): one for one in resolved}
    found = []
    for each in optimum.candidates:
        if each.role == "front":
            continue
        one = known.get(id(each))
        computed = None if one is None else one.computed
        first = None if one is None else resolve.computed(one, COG)
        checked = each.cog_max_mm is not None and first is not None
        found.append(
            ChosenDesign(
                role=each.role,
                limit=each.cog_max_mm,
                inputs=each.inputs,
                surrogate=each.predicted,
                resolved=one is not None,
                fem=None if isinstance(computed, FailedSolve) else computed,
                failure=computed.sentence if isinstance(computed, FailedSolve) else "",
                within_limit=first <= each.cog_max_mm if checked else None,  # type: ignore[operator]
                gain=None if one is None else resolve.improvement(resolved, one),
            )
        )
    return tuple(found)

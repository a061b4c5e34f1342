"""The whole of an optimisation: front, choices, what finite elements say of them, as files."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import dolfingrip
from dolfingrip.design.optimum import pareto, resolve
from dolfingrip.design.optimum.pareto import COG, FORCE, Front, Settings
from dolfingrip.design.optimum.resolve import Candidate, Evaluate, Failure, Resolved
from dolfingrip.design.surrogate import rows
from dolfingrip.design.surrogate.surrogate import Surrogate


@dataclass(frozen=True)
class Optimum:
    """A front and the choices along it.

    Attributes:
        front: of the surrogate.
        candidates: what is worth computing again: choices first, points along the front last.
        missed: COG limits (mm) below the whole front.
    """

    surrogate: Surrogate
    settings: Settings
    front: Front
    candidates: list[Candidate]
    missed: list[float]


def find(
    surrogate: Surrogate,
    limits_mm: Sequence[float],
    settings: Settings,
    progress: Callable[[int], None] | None = None,
    *,
    along: int = 10,
) -> Optimum:
    """Find the front within the surrogate's range, and choose on it.

    Args:
        limits_mm: COG limits to choose by.
        progress: called with the generations done.
        along: number of points along the front to compute again.

    Raises:
        ConfigError: one line, where the surrogate lacks an objective.
    """
    predict, low, high = pareto.objectives(surrogate), surrogate.inputs.low, surrogate.inputs.high
    front = pareto.fronts(predict, low, high, settings, progress=progress)[settings.generations]
    chosen, polished, missed = [], [], []
    for limit in limits_mm:
        place = front.choose(limit)
        if place is None:
            missed.append(limit)
            continue
        start = front.designs[place]
        chosen.append(resolve.candidate(surrogate, start, "chosen", limit))
        better = pareto.polish(predict, low, high, start, limit)
        if better is not None:
            polished.append(resolve.candidate(surrogate, better[0], "polished", limit))
    candidates = [
        *chosen,
        *resolve.original(surrogate),
        *polished,
        *resolve.along(surrogate, front, along),
    ]
    return Optimum(surrogate, settings, front, candidates, missed)


def write_front(optimum: Optimum, out: Path) -> None:
    """Write ``front.csv``: the designs of the front and the surrogate's outputs."""
    predicted = optimum.surrogate.predict(optimum.front.designs, warn=False)
    names = (
        *optimum.surrogate.input_names,
        *(f"surrogate.{name}" for name in optimum.surrogate.output_names),
    )
    rows.write(
        out / "front.csv",
        [
            dict(zip(names, [*map(float, x), *map(float, y)], strict=True))
            for x, y in zip(optimum.front.designs, predicted, strict=True)
        ],
    )


def compute(optimum: Optimum, evaluate: Evaluate | None) -> list[Resolved]:
    """The candidates by finite elements; none where there is no ``evaluate``."""
    return [] if evaluate is None else resolve.resolve(optimum.candidates, evaluate)


def write(optimum: Optimum, resolved: Sequence[Resolved], out: Path) -> dict[str, Any]:
    """Write ``optimum.json`` and, where there is one, ``resolved.csv``; the JSON's content."""
    if resolved:
        rows.write(out / "resolved.csv", resolve.rows(resolved))
    facts = {
        "settings": asdict(optimum.settings),
        "surrogate_sha256": optimum.surrogate.sha256(),
        "front_points": len(optimum.front),
        "front_cog_offset_mm": [float(optimum.front.cog_mm[0]), float(optimum.front.cog_mm[-1])],
        "limits_below_the_front_mm": optimum.missed,
        "designs": _designs(optimum, resolved),
        "surrogate_error_on_front": errors(resolved),
        "versions": {
            "dolfingrip": dolfingrip.__version__,
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in ("numpy", "pymoo", "moocore", "torch")},
        },
    }
    text = json.dumps(facts, indent=2, ensure_ascii=False) + "\n"
    (out / "optimum.json").write_text(text, encoding="utf-8")
    return facts


def errors(resolved: Sequence[Resolved]) -> dict[str, dict[str, float]]:
    """The surrogate's error at the points along the front, by output; empty where none is known."""
    front = [one for one in resolved if one.candidate.role == "front"]
    names = front[0].candidate.predicted if front else ()
    found = {name: resolve.error(front, name) for name in names}
    return {name: asdict(error) for name, error in found.items() if error.designs}


def improvement(resolved: Sequence[Resolved], one: Resolved) -> float | None:
    """Force over the original's, less 1 (the paper's φ), both by finite elements."""
    force = _computed(one, FORCE)
    original = next((each for each in resolved if each.candidate.role == "original"), None)
    reference = None if original is None else _computed(original, FORCE)
    return None if force is None or not reference else force / reference - 1


def _computed(one: Resolved, name: str) -> float | None:
    return None if isinstance(one.computed, Failure) else one.computed.get(name)


def _designs(optimum: Optimum, resolved: Sequence[Resolved]) -> list[dict[str, Any]]:
    known = {id(one.candidate): one for one in resolved}
    found = []
    for candidate in optimum.candidates:
        if candidate.role == "front":
            continue
        facts: dict[str, Any] = {
            "role": candidate.role,
            "cog_max_mm": candidate.cog_max_mm,
            "inputs": candidate.inputs,
            "surrogate": candidate.predicted,
        }
        one = known.get(id(candidate))
        if one is not None:
            failed = isinstance(one.computed, Failure)
            facts["fem"] = None if failed else one.computed
            if isinstance(one.computed, Failure):
                facts["failure"] = one.computed.sentence
            cog = _computed(one, COG)
            if candidate.cog_max_mm is not None and cog is not None:
                facts["fem_within_limit"] = cog <= candidate.cog_max_mm
            facts["force_over_original"] = improvement(resolved, one)
        found.append(facts)
    return found

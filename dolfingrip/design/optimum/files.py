"""An optimisation as files: ``front.csv``, ``resolved.csv`` and ``optimum.json``."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

import dolfingrip
from dolfingrip.design.optimum import resolve
from dolfingrip.design.optimum.optimum import Optimum
from dolfingrip.design.optimum.pareto import COG
from dolfingrip.design.optimum.resolve import Failure, Resolved
from dolfingrip.files import table, whole


def write_front(optimum: Optimum, out: Path) -> None:
    """Write ``front.csv``: the designs of the front and the surrogate's outputs."""
    predicted = optimum.surrogate.predict(optimum.front.designs, warn=False)
    names = (
        *optimum.surrogate.input_names,
        *(f"surrogate.{name}" for name in optimum.surrogate.output_names),
    )
    table.write(
        out / "front.csv",
        [
            dict(zip(names, [*map(float, x), *map(float, y)], strict=True))
            for x, y in zip(optimum.front.designs, predicted, strict=True)
        ],
    )


def write(optimum: Optimum, resolved: Sequence[Resolved], out: Path) -> dict[str, Any]:
    """Write ``optimum.json`` and, where there is one, ``resolved.csv``; the JSON's content."""
    if resolved:
        table.write(out / "resolved.csv", resolve.rows(resolved))
    facts = {
        "settings": asdict(optimum.settings),
        "surrogate_sha256": optimum.surrogate.sha256(),
        "front_points": len(optimum.front),
        "front_cog_offset_mm": [float(optimum.front.cog_mm[0]), float(optimum.front.cog_mm[-1])],
        "limits_below_the_front_mm": optimum.missed,
        "designs": _designs(optimum, resolved),
        "surrogate_error_on_front": resolve.errors(resolved),
        "versions": {
            "dolfingrip": dolfingrip.__version__,
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in ("numpy", "pymoo", "moocore", "torch")},
        },
    }
    text = json.dumps(facts, indent=2, ensure_ascii=False) + "\n"
    whole.write(out / "optimum.json", text)
    return facts


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
            cog = resolve.computed(one, COG)
            if candidate.cog_max_mm is not None and cog is not None:
                facts["fem_within_limit"] = cog <= candidate.cog_max_mm
            facts["force_over_original"] = resolve.improvement(resolved, one)
        found.append(facts)
    return found

"""An optimisation: the front of a surrogate, and what is chosen along it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from dolfingrip.design.optimum import pareto, resolve
from dolfingrip.design.optimum.genetic import Settings
from dolfingrip.design.optimum.pareto import Front
from dolfingrip.design.optimum.resolve import Evaluate, Resolved, SelectedDesign
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
    candidates: list[SelectedDesign]
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
        chosen.append(resolve.selected(surrogate, start, "chosen", limit))
        better = pareto.polish(predict, low, high, start, limit)
        if better is not None:
            polished.append(resolve.selected(surrogate, better[0], "polished", limit))
    candidates = [
        *chosen,
        *resolve.original(surrogate),
        *polished,
        *resolve.along(surrogate, front, along),
    ]
    return Optimum(surrogate, settings, front, candidates, missed)


def compute(optimum: Optimum, evaluate: Evaluate) -> list[Resolved]:
    """The candidates by finite elements."""
    return resolve.resolve(optimum.candidates, evaluate)

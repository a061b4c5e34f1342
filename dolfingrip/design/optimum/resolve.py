"""Designs of the front computed again by finite elements, and the surrogate's error there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from dolfingrip.channels import FORCE
from dolfingrip.design.optimum.pareto import Front, Matrix, Vector
from dolfingrip.design.surrogate.surrogate import Surrogate

Outputs = dict[str, float]


@dataclass(frozen=True)
class FailedSolve:
    """Why a design has no outputs, in one sentence."""

    sentence: str


Evaluate = Callable[[Sequence[dict[str, float]]], list[Outputs | FailedSolve]]
"""From designs (inputs by name) to the outputs of each by name, or why it has none."""


@dataclass(frozen=True)
class SelectedDesign:
    """A design to compute again.

    Attributes:
        role: why: ``chosen``, ``polished``, ``original`` or ``front``.
        cog_max_mm: the limit it was chosen by, where it was.
        inputs, predicted: the design and the surrogate's outputs, by name.
    """

    role: str
    cog_max_mm: float | None
    inputs: dict[str, float]
    predicted: Outputs


@dataclass(frozen=True)
class Resolved:
    """A candidate and what finite elements gave for it."""

    candidate: SelectedDesign
    computed: Outputs | FailedSolve

    def miss(self, name: str) -> float:
        """Surrogate minus finite elements, in the output's unit; NaN where these failed."""
        if isinstance(self.computed, FailedSolve):
            return float("nan")
        return self.candidate.predicted[name] - self.computed[name]


@dataclass(frozen=True)
class Error:
    """The surrogate's error on some designs.

    Attributes:
        designs: how many it was found on.
        rms, largest: in the output's unit.
        relative: ``rms`` over the mean size of the computed output.
    """

    designs: int
    rms: float
    largest: float
    relative: float


def selected(
    surrogate: Surrogate, design: Vector, role: str, cog_max_mm: float | None = None
) -> SelectedDesign:
    """A design, shape (inputs,), with what the surrogate says of it."""
    predicted = surrogate.predict(design[None, :], warn=False)[0]
    return SelectedDesign(
        role,
        cog_max_mm,
        dict(zip(surrogate.input_names, map(float, design), strict=True)),
        dict(zip(surrogate.output_names, map(float, predicted), strict=True)),
    )


def along(surrogate: Surrogate, front: Front, count: int) -> list[SelectedDesign]:
    """Points evenly far apart along the front."""
    designs: Matrix = front.designs[front.spread(count)]
    return [selected(surrogate, design, "front") for design in designs]


def original(surrogate: Surrogate) -> list[SelectedDesign]:
    """The design with all inputs 0, which a morph leaves as it is; none where it is outside."""
    zero = np.zeros(len(surrogate.input_names))
    inside = (surrogate.inputs.low <= zero).all() and (zero <= surrogate.inputs.high).all()
    morphs = all(name.startswith("morph.") for name in surrogate.input_names)
    return [selected(surrogate, zero, "original")] if inside and morphs else []


def resolve(candidates: Sequence[SelectedDesign], evaluate: Evaluate) -> list[Resolved]:
    """Compute the candidates, each design once whatever it is wanted for."""
    distinct = list({tuple(one.inputs.items()): one.inputs for one in candidates}.values())
    found = dict(zip(map(_key, distinct), evaluate(distinct), strict=True))
    return [Resolved(one, found[_key(one.inputs)]) for one in candidates]


def _key(inputs: dict[str, float]) -> tuple[tuple[str, float], ...]:
    return tuple(inputs.items())


def error(resolved: Iterable[Resolved], name: str) -> Error:
    """The surrogate's error of one output on the designs that finite elements could compute."""
    good = [one for one in resolved if not isinstance(one.computed, FailedSolve)]
    if not good:
        nothing = float("nan")
        return Error(0, nothing, nothing, nothing)
    miss = np.array([one.miss(name) for one in good])
    size = np.mean(
        [abs(one.computed[name]) for one in good if not isinstance(one.computed, FailedSolve)]
    )
    rms = float(np.sqrt(np.mean(miss**2)))
    return Error(len(good), rms, float(np.abs(miss).max()), rms / float(size))


def errors(resolved: Sequence[Resolved]) -> dict[str, dict[str, float]]:
    """The surrogate's error at the points along the front, by output; empty where none is known."""
    front = [one for one in resolved if one.candidate.role == "front"]
    names = front[0].candidate.predicted if front else ()
    found = {name: error(front, name) for name in names}
    return {name: asdict(error) for name, error in found.items() if error.designs}


def improvement(resolved: Sequence[Resolved], one: Resolved) -> float | None:
    """Force over the original's, less 1 (the paper's φ), both by finite elements."""
    force = computed(one, FORCE.name)
    original = next((each for each in resolved if each.candidate.role == "original"), None)
    reference = None if original is None else computed(original, FORCE.name)
    return None if force is None or not reference else force / reference - 1


def computed(one: Resolved, name: str) -> float | None:
    """One of its outputs by finite elements; None where they failed."""
    return None if isinstance(one.computed, FailedSolve) else one.computed.get(name)


def rows(resolved: Iterable[Resolved]) -> list[dict[str, object]]:
    """A table: role, inputs, outputs by surrogate and by finite elements, status."""
    table = []
    for one in resolved:
        row: dict[str, object] = {
            "role": one.candidate.role,
            "cog_max_mm": one.candidate.cog_max_mm,
        }
        row |= one.candidate.inputs
        failed = isinstance(one.computed, FailedSolve)
        for name, value in one.candidate.predicted.items():
            row[f"surrogate.{name}"] = value
            row[f"fem.{name}"] = (
                None if isinstance(one.computed, FailedSolve) else one.computed[name]
            )
        row["status"] = "failed" if failed else "done"
        row["failure"] = one.computed.sentence if isinstance(one.computed, FailedSolve) else None
        table.append(row)
    return table

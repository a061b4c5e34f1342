"""The result of an experiment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from mpi4py import MPI

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.results.outcome import Outcome
from dolfingrip.experiments.results.turning_point import TurningPoint
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton import memory
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import Failure

Row = dict[str, Any]
"""Readings of one stop, by column."""


@dataclass(frozen=True, slots=True)
class PlatePose:
    """A point of the rigid plane (mm) and its normal towards the finger."""

    point_mm: tuple[float, float, float]
    normal: tuple[float, float, float]


@dataclass(slots=True, repr=False)
class Result:
    """The result of an experiment.

    Attributes:
        kind: the experiment's name.
        rows: a dictionary by column for each stop.
        failure: why the path ended early, if it did; the rows up to there are valid.
        turning_point: turning point of the blocked-force curve, if it has one.
        plate: where the force sensor stood, if there was one.
        facts: contents of ``run.json`` without the configuration.
        outcome: outcome of a grasp.
        sensitivities: rows of ``sensitivity.csv``, if derivatives were asked for.
        second_runs: for the key of each choice of the model whose difference was asked for: why
            the run with the other choice ended early; None if it did not.
    """

    kind: str
    config: Config
    rows: list[Row] = field(default_factory=list)
    failure: Failure | None = None
    turning_point: TurningPoint | None = None
    plate: PlatePose | None = None
    outcome: Outcome | None = None
    facts: dict[str, Any] = field(default_factory=dict)
    sensitivities: list[dict[str, Any]] = field(default_factory=list)
    second_runs: dict[str, Failure | None] = field(default_factory=dict)

    def column(self, name: str) -> np.ndarray:
        """(rows,) values of a column as floats, NaN where it is empty.

        Raises:
            ConfigError: one line with the columns there are, where no row has this one.
        """
        numbers = [key for key, values in self.columns().items() if not isinstance(values[0], str)]
        if self.rows and name not in numbers:
            raise ConfigError(
                f"column {name}: not in a result of {self.kind}; allowed: {', '.join(numbers)}"
            )
        return np.array([row.get(name, np.nan) for row in self.rows], dtype=float)

    def __repr__(self) -> str:
        """One line without the readings themselves: how many there are, and how the run ended."""
        ending = "complete" if self.failure is None else self.failure.sentence()
        if self.outcome is not None:
            ending += f"; {self.outcome.kind}: {self.outcome.sentence}"
        return f"<Result of {self.kind}: {len(self.rows)} readings, {ending}>"

    def columns(self) -> dict[str, list[Any]]:
        """The table by column."""
        names = dict.fromkeys(name for row in self.rows for name in row)
        return {name: [row.get(name) for row in self.rows] for name in names}


def facts(
    result: Result, newton: Newton, profile: Profile, wall_s: float, notes: Sequence[str]
) -> dict[str, Any]:
    """Contents of ``run.json`` without the configuration."""
    model = newton.model
    topology = model.domain.mesh.topology
    return {
        "experiment": result.kind,
        "complete": result.failure is None,
        "mesh": {
            "elements": int(topology.index_map(3).size_global),
            "dofs": model.dofs,
            "half": model.domain.half,
        },
        "newton": {
            "iterations": newton.counts.iterations,
            "factorisations": newton.counts.factorisations,
            "load_steps": sum(row["load_steps"] for row in result.rows),
            "damped_steps": newton.counts.damped,
            "linear_solver": "iterative" if newton.linear_solver.iterative else "direct",
            "matrix_patterns": newton.tangent.patterns + 1,
        },
        "failure": None
        if result.failure is None
        else {
            "kind": str(result.failure.kind),
            "last_good": result.failure.last_good,
            "sentence": result.failure.sentence(),
        },
        "notes": list(notes),
        "turning_point": None if result.turning_point is None else asdict(result.turning_point),
        "outcome": None if result.outcome is None else asdict(result.outcome),
        "ranks": model.comm.size,
        "compiled_for": jit.PROCESSOR,
        "wall_s": round(wall_s, 3),
        "memory_forecast_MB": round(newton.linear_solver.forecast_MB),
        "peak_memory_MB": round(model.comm.allreduce(memory.peak_MB(), MPI.SUM)),
        "profile": profile.as_dict(),
    }

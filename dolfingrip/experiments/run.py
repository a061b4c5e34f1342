"""Run an experiment along its pressures and keep what it yields, row by row."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from mpi4py import MPI

from dolfingrip.config import Config
from dolfingrip.experiments import turning_point
from dolfingrip.experiments.finger import FingerModel, build
from dolfingrip.experiments.keeper import COLUMNS, Keeper, Row
from dolfingrip.experiments.landings import Landing, landings
from dolfingrip.experiments.notes import notes
from dolfingrip.experiments.observation import Observation
from dolfingrip.experiments.turning_point import TurningPoint
from dolfingrip.experiments.undeformed import load_domain
from dolfingrip.mechanics.failure import Failure
from dolfingrip.mechanics.newton import Newton
from dolfingrip.mechanics.path import LoadPath
from dolfingrip.mechanics.profile import Profile
from dolfingrip.mechanics.state import State

Kind = Literal["bending", "blocked_force"]


@dataclass(frozen=True, slots=True)
class PlatePose:
    """A point of the rigid plane (mm) and its normal towards the finger."""

    point_mm: tuple[float, float, float]
    normal: tuple[float, float, float]


@dataclass(slots=True)
class Result:
    """What an experiment yielded.

    Attributes:
        kind: ``bending`` or ``blocked_force``.
        rows: one dictionary a landing, by column.
        failure: why the path ended early, if it did; the rows up to there are good.
        turning: of the blocked-force curve, where it turns.
        plate: where the force sensor stood.
        facts: contents of ``run.json`` besides the configuration.
    """

    kind: Kind
    config: Config
    rows: list[Row] = field(default_factory=list)
    failure: Failure | None = None
    turning: TurningPoint | None = None
    plate: PlatePose | None = None
    facts: dict[str, Any] = field(default_factory=dict)

    def column(self, name: str) -> np.ndarray:
        """(rows,) values of a column as floats, NaN where it is empty."""
        return np.array([row.get(name, np.nan) for row in self.rows], dtype=float)

    def columns(self) -> dict[str, list[Any]]:
        """The table by column."""
        names = [name for name in COLUMNS if any(name in row for row in self.rows)]
        return {name: [row.get(name) for row in self.rows] for name in names}


def run(
    kind: Kind,
    config: Config | None = None,
    *,
    out: Path | None = None,
    comm: MPI.Comm = MPI.COMM_WORLD,
    progress: Callable[[Row], None] = lambda row: None,
    visit: Callable[[FingerModel, Row], None] = lambda finger, row: None,
) -> Result:
    """Pressurise the finger, free or against the plate.

    Args:
        kind: ``bending`` or ``blocked_force``.
        config: all that the simulation depends on; default: the reference finger.
        out: folder for ``result.csv``, ``run.json`` and ``fields.pvd``; nothing is written
            where None.
        comm: ranks to run on.
        progress: called with each new row, on every rank.
        visit: likewise, with the finger as it then is; it must leave the finger so.

    Raises:
        ConfigError: bad mesh or geometry, in one line.
    """
    config = config or Config()
    start = time.perf_counter()
    profile = Profile()
    with profile.phase("mesh"):
        domain = load_domain(config, comm)
    with profile.phase("forms"):
        finger = build(config, domain, plate=kind == "blocked_force")
        observation = Observation(finger)
    result = Result(kind, config)
    if finger.plate is not None:
        normal, offset = finger.plate.normal, float(finger.plate.offset.value)
        result.plate = PlatePose(tuple(offset * normal), tuple(normal))
    gaps: list[dict[str, float]] = []
    with ExitStack() as stack:
        keep = stack.enter_context(Keeper(out, kind, finger, profile)) if out is not None else None
        newton = Newton(finger.model, config.solver, profile, finger.volume)
        rest = finger.model.state()
        path = LoadPath(newton, _longest(config, rest), lambda: _intersecting(finger))
        last: Landing | None = None
        for landing in landings(config):
            clock = finger.model.time_s + _seconds(config, last, landing)
            arrival = path.advance(landing.controls(config, rest, clock))
            if arrival.failure is not None:
                result.failure = arrival.failure
                break
            with profile.phase("observation"):
                if not result.rows:
                    observation.tare()
                readings = observation.read()
                gaps.append(observation.gaps.all_mm())
            row: Row = {
                "experiment": kind,
                "specimen": "simulated",
                "cycle": 1,
                "branch": landing.branch,
                **readings,
                "iterations": arrival.iterations,
                "load_steps": arrival.steps,
            }
            last = landing
            result.rows.append(row)
            if keep is not None:
                keep.append(row)
            progress(row)
            visit(finger, row)
        if kind == "blocked_force":
            result.turning = _turning(result, gaps, config)
        result.facts = _facts(result, finger, newton, profile, time.perf_counter() - start)
        if keep is not None:
            keep.finish(result.facts)
    comm.Barrier()
    return result


def _longest(config: Config, rest: State) -> dict[str, float]:
    """Longest load step of the control that is led."""
    if config.experiment.control == "pressure":
        return {"pressure_kPa": config.solver.max_step_kPa}
    volume = rest.controls["cavity_volume_mm3"]
    return {"cavity_volume_mm3": config.experiment.step_volume_ratio * volume}


def _seconds(config: Config, last: Landing | None, landing: Landing) -> float:
    """Time of the ramp between two readings; that of ``step_kPa`` where the volume is led."""
    experiment = config.experiment
    if last is None:
        return 0.0
    if landing.pressure_kPa is None or last.pressure_kPa is None:
        return experiment.step_kPa / experiment.rate_kPa_per_s
    return abs(landing.pressure_kPa - last.pressure_kPa) / experiment.rate_kPa_per_s


def _intersecting(finger: FingerModel) -> str:
    contact = finger.model.contact
    passed = contact is not None and contact.intersects(finger.model.u.x.array)
    return "the skin passes through itself" if passed else ""


def _turning(result: Result, gaps: list[dict[str, float]], config: Config) -> TurningPoint | None:
    loading = [i for i, row in enumerate(result.rows) if row["branch"] == "loading"]
    return turning_point.find(
        result.column("pressure_kPa")[loading],
        result.column("force_N")[loading],
        [gaps[i] for i in loading],
        config.contact.barrier_mm,
    )


def _facts(
    result: Result, finger: FingerModel, newton: Newton, profile: Profile, wall_s: float
) -> dict[str, Any]:
    model = finger.model
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
            "iterations": newton.iterations,
            "factorisations": newton.factorisations,
            "load_steps": sum(row["load_steps"] for row in result.rows),
            "matrix_patterns": newton.tangent.patterns + 1,
        },
        "failure": None
        if result.failure is None
        else {
            "kind": str(result.failure.kind),
            "last_good": result.failure.last_good,
            "sentence": result.failure.sentence(),
        },
        "notes": notes(result.config),
        "turning_point": None if result.turning is None else asdict(result.turning),
        "ranks": model.comm.size,
        "wall_s": round(wall_s, 3),
        "profile": profile.as_dict(),
    }

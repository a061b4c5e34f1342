"""Run an experiment along its pressures and keep what it yields, row by row."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from mpi4py import MPI

from dolfingrip.config import Config
from dolfingrip.experiments import turning_point
from dolfingrip.experiments.display import displayed
from dolfingrip.experiments.finger import FingerModel, build
from dolfingrip.experiments.keeper import Keeper, Row
from dolfingrip.experiments.landings import landings
from dolfingrip.experiments.march import Stop, march
from dolfingrip.experiments.observation import Observation
from dolfingrip.experiments.result import Kind, PlatePose, Result, facts
from dolfingrip.experiments.turning_point import TurningPoint
from dolfingrip.experiments.undeformed import load_domain
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.limit_point import Summit
from dolfingrip.mechanics.path.path import LoadPath

__all__ = ["Kind", "PlatePose", "Result", "Row", "run"]


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
        keep = (
            stack.enter_context(Keeper(out, kind, config, finger.model, profile))
            if out is not None
            else None
        )
        newton = Newton(finger.model, config.solver, profile)
        rest = finger.model.state()
        path = LoadPath(
            newton,
            _longest(config, rest),
            passable=lambda attempted: _passable(finger, attempted.get("pressure_kPa", 0.0)),
        )
        stops = [
            Stop(landing.controls(config, rest), landing.branch, landing.cycle)
            for landing in landings(config)
        ]
        if stops[0].controls.get("pressure_kPa"):
            result.failure = path.advance({"pressure_kPa": 0.0, "time_s": 0.0}).failure
            observation.tare()

        def read() -> dict[str, float]:
            if not result.rows and not stops[0].controls.get("pressure_kPa"):
                observation.tare()
            readings = observation.read()
            gaps.append(observation.gaps_mm)
            return displayed(config, readings)

        def reached(row: Row) -> None:
            progress(row)
            visit(finger, row)

        if result.failure is None:
            result.failure = march(
                kind,
                path,
                stops,
                read,
                rows=result.rows,
                keep=keep,
                progress=reached,
                profile=profile,
            )
        if kind == "blocked_force":
            result.turning = _turning(result, gaps, config)
        result.facts = facts(result, finger.model, newton, profile, time.perf_counter() - start)
        if keep is not None:
            keep.finish(result.facts)
    comm.Barrier()
    return result


def _longest(config: Config, rest: State) -> dict[str, float]:
    """Longest load step of the control that is led."""
    longest = {}
    if config.solver.max_step_s is not None:
        longest["time_s"] = config.solver.max_step_s
    if config.experiment.control == "pressure":
        return {"pressure_kPa": config.solver.max_step_kPa, **longest}
    volume = rest.controls["cavity_volume_mm3"]
    return {"cavity_volume_mm3": config.experiment.step_volume_ratio * volume, **longest}


def _passable(finger: FingerModel, beyond_kPa: float) -> bool:
    """Whether a finger led by pressure goes on at a falling one where its volume is led."""
    if finger.config.experiment.control == "volume":
        return False
    settings = finger.config.solver
    return Summit(finger.model, finger.cavity, finger.enclosed, settings).is_near(beyond_kPa)


def _turning(result: Result, gaps: list[dict[str, float]], config: Config) -> TurningPoint | None:
    loading = [i for i, row in enumerate(result.rows) if row["branch"] == "loading"]
    return turning_point.find(
        result.column("pressure_kPa")[loading],
        result.column("force_N")[loading],
        [gaps[i] for i in loading],
        config.contact.barrier_mm,
    )

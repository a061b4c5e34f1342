"""Finite elements behind :data:`resolve.Evaluate`: a small campaign, which can be resumed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from dolfingrip.config import Config
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign import objective as ours
from dolfingrip.design.campaign.plan import OBJECTIVE, Plan, quantities
from dolfingrip.design.optimum.resolve import Evaluate, FailedSolve, Outputs
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.run import Progress, silent


def evaluator(
    base: Config,
    outputs: Sequence[str],
    out: Path,
    where: Where,
    *,
    objective: str = OBJECTIVE,
    progress: Progress = silent,
) -> Evaluate:
    """Compute designs by a campaign in ``out``; what it already holds is not computed again.

    Args:
        base: configuration that the inputs are put into.
        outputs: quantities wanted.
        out: folder of the campaign.
        where: workers.
        objective: import path of what computes a design.
        progress: called with each answer stored.

    Raises:
        ConfigError: one line, where a quantity cannot be computed.
    """
    wanted = quantities(outputs, ours.QUANTITIES if objective == OBJECTIVE else outputs)

    def evaluate(designs: Sequence[dict[str, float]]) -> list[Outputs | FailedSolve]:
        plans = [_plan(base, (design,), wanted, objective) for design in designs]
        whole = _plan(base, tuple(designs), wanted, objective)
        campaign.run(whole, out, where, progress=progress)
        rows = campaign.read(out).by_key()
        return [_found(rows[plan.designs()[0].key]) for plan in plans]

    return evaluate


def _plan(
    base: Config, points: tuple[dict[str, float], ...], wanted: tuple[str, ...], objective: str
) -> Plan:
    return Plan(base, tuple(points[0]), tuple(map(dict, points)), wanted, objective)


def _found(row: dict[str, Any]) -> Outputs | FailedSolve:
    if row["status"] == "done":
        return {name: float(value) for name, value in row["outputs"].items()}
    return FailedSolve(row["failure"] or "not computed")

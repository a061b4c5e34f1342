"""Grasps as designs of a campaign: what became of each, the angles, the margin and the bruising."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from dolfingrip import config as configuration
from dolfingrip.channels import FINGERS
from dolfingrip.design.campaign.evaluate import Outcome
from dolfingrip.jobs.job import JobFailure

if TYPE_CHECKING:
    from dolfingrip.experiments.result import Result

OBJECTIVE: Final = "dolfingrip.design.campaign.grasps:simulate"
"""Import path of :func:`simulate`."""

READ: Final = ("angle_A_deg", "angle_B_deg", "angle_C_deg", "slip_mm", "force_closure")
"""Columns of the last row before the lift, or of the last one where the grasp ended before."""

QUANTITIES: Final = (
    *("picked_up", "outcome_s", "margin", "normal_N", "weight_N", "contact_pressure_kPa"),
    *READ,
)
"""What a grasp yields: 1 where the food was picked up, else 0; when that was decided; how many
times its weight the fingers can bear in any direction; the sum of normal forces before the lift;
the weight; the largest contact pressure on the food; and readings before the lift."""

PICKUP: Final = "pickup_margin"
"""What a search maximises: ``margin`` where the food was picked up. Where it was not, less than 0:
minus the part of its weight that the fingers do not bear at the end, so −1 where they let it go.
It has no gradient: a grasp with friction remembers its way."""

NO_CLASS: Final = "no class"
"""Class of a failure: the grasp ended early and nothing had been decided."""


def simulate(config: dict[str, Any], quantities: tuple[str, ...], ranks: int) -> Outcome:
    """Compute a grasp in this process.

    The curve has the class of the outcome and its sentence, and a grasp's main columns.

    Args:
        config: resolved, as nested dictionaries.
        quantities: those of :data:`QUANTITIES`, or :data:`PICKUP`, that are wanted.
        ranks: 1.

    Raises:
        JobFailure: the grasp ended early without an outcome.
        ConfigError: there is no such gripper.
    """
    from mpi4py import MPI

    from dolfingrip.experiments import run
    from dolfingrip.experiments.results import record

    if ranks != 1:
        raise configuration.ConfigError(f"--ranks {ranks}: allowed: 1 for a grasp")
    result = run("grasp", configuration.from_dict(config), comm=MPI.COMM_SELF)
    curve: dict[str, Any] = {
        name: list(map(float, result.column(name)))
        for name in ("time_s", "pressure_kPa", "normal_A_N", "table_N", "object_z_mm", *READ)
    }
    if result.outcome is None:
        failure = result.failure
        kind = NO_CLASS if failure is None else str(failure.kind)
        sentence = "" if failure is None else failure.sentence()
        raise JobFailure(kind, sentence, {"curve": curve})
    curve |= {"outcome": str(result.outcome.kind), "sentence": result.outcome.sentence}
    outputs = outputs_of(result)
    return Outcome(
        {name: outputs[name] for name in quantities},
        curve=curve,
        iterations=result.facts.newton.iterations,
        versions=record.versions(),
    )


def outputs_of(result: Result) -> dict[str, float]:
    """Values of all :data:`QUANTITIES`, and of :data:`PICKUP`, of a grasp with an outcome."""
    from dolfingrip.files.run import GraspKind

    assert result.outcome is not None
    before = [row for row in result.rows if row["table_z_mm"] >= 0] or result.rows
    held, last = before[-1], result.rows[-1]
    weight_N = float(result.rows[0]["table_N"])
    margin = float(last["force_closure"]) * _normal_N(last) / weight_N
    kind = result.outcome.kind
    on_table = min(max(float(last["table_N"]) / weight_N, 0.0), 1.0)
    if kind in (GraspKind.DROPPED, GraspKind.EJECTED):
        on_table = 1.0
    return {
        "picked_up": float(kind is GraspKind.PICKED_UP),
        "outcome_s": result.outcome.time_s,
        "margin": margin,
        PICKUP: margin if kind is GraspKind.PICKED_UP else -on_table,
        "normal_N": _normal_N(held),
        "weight_N": weight_N,
        "contact_pressure_kPa": float(result.column("contact_pressure_kPa").max()),
        **{name: float(held[name]) for name in READ},
    }


def _normal_N(row: dict[str, Any]) -> float:
    """Sum of the fingers' normal forces on the food."""
    return sum(float(row[f"normal_{letter}_N"]) for letter in FINGERS)

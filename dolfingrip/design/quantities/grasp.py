"""Numbers of a grasp: what became of it, the angles, the margin and the bruising."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

import numpy as np

from dolfingrip.channels import FINGERS
from dolfingrip.config import ConfigError
from dolfingrip.design.quantities.quantity import (
    AskedDesign,
    Outcome,
    Places,
    Quantity,
    QuantitySource,
)
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.files.run import GraspKind
from dolfingrip.jobs.job import JobFailure

GRASP: Final = "grasp"
"""Name of the experiment."""

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


class GraspNumbers(QuantitySource):
    """Numbers of a grasp at the highest pressure."""

    names: ClassVar = (*QUANTITIES, PICKUP)

    def quantity(self, said: str, name: str, places: Places, experiment: str | None) -> Quantity:
        if places or experiment not in (None, GRASP):
            raise ConfigError(
                f"{said}: of a grasp at experiment.max_pressure_kPa; allowed: without a place"
            )
        return Quantity(name, GRASP)

    def check_design(self, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        if design.ranks != 1:
            raise ConfigError(f"--ranks {design.ranks}: allowed: 1 for a grasp")
        Request.of(GRASP, design.config)

    def add(self, outcome: Outcome, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        self.check_design(wanted, design)
        assert outcome.curve is not None
        answer = compute(Request.of(GRASP, design.config))
        none = np.empty(0)
        for name in ("time_s", "pressure_kPa", "normal_A_N", "table_N", "object_z_mm", *READ):
            outcome.curve[name] = answer.columns.get(name, none).tolist()
        outcome.iterations = (outcome.iterations or 0) + answer.iterations
        if answer.outcome is None:
            kind = answer.failure_class or NO_CLASS
            raise JobFailure(kind, answer.failure or "", {"curve": outcome.curve})
        outcome.curve["outcome"] = answer.outcome["kind"]
        outcome.curve["sentence"] = answer.outcome["sentence"]
        outputs = outputs_of(answer)
        outcome.outputs |= {str(quantity): outputs[quantity.name] for quantity in wanted}


def outputs_of(answer: Answer) -> dict[str, float]:
    """Return the numbers of a grasp with an outcome.

    Args:
        answer: with all columns of the grasp.

    Returns:
        Values of all :data:`QUANTITIES`, and of :data:`PICKUP`.
    """
    assert answer.outcome is not None
    columns = answer.columns
    before = np.flatnonzero(columns["table_z_mm"] >= 0)
    held = int(before[-1]) if before.size else -1
    normal_N = np.sum([columns[f"normal_{letter}_N"] for letter in FINGERS], axis=0)
    weight_N = float(columns["table_N"][0])
    margin = float(columns["force_closure"][-1] * normal_N[-1] / weight_N)
    kind = GraspKind(answer.outcome["kind"])
    on_table = min(max(float(columns["table_N"][-1]) / weight_N, 0.0), 1.0)
    if kind in (GraspKind.DROPPED, GraspKind.EJECTED):
        on_table = 1.0
    return {
        "picked_up": float(kind is GraspKind.PICKED_UP),
        "outcome_s": float(answer.outcome["time_s"]),
        "margin": margin,
        PICKUP: margin if kind is GraspKind.PICKED_UP else -on_table,
        "normal_N": float(normal_N[held]),
        "weight_N": weight_N,
        "contact_pressure_kPa": float(columns["contact_pressure_kPa"].max()),
        **{name: float(columns[name][held]) for name in READ},
    }

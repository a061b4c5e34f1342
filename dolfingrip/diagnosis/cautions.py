"""What a diagnosis tells its reader to beware of, a sentence each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.inference.verdict import Verdict
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.simulated import SimulationFailure

MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as only a graded mesh of hexahedra tells it: it "
    "may be named as an effect; compare readings with a finer mesh (mesh.refine=2, mesh.size_mm)"
)
"""Said where there is no second mesh to compare with."""


def of_simulation(base: BaseSimulation) -> list[str]:
    """Effects that could not be simulated, and a mesh without another to compare with."""
    found = []
    if not base.mesh.size and any(t.experiment != "coupon" for t in base.measurement.tests):
        found.append(MESH_UNKNOWN)
    for candidate in base.candidates:
        if candidate.failures and not len(candidate.shapes):
            why = candidate.failures[0].sentence
            found.append(f"{candidate.name} could not be tried: {why}")
    return found


def not_reached(
    measurement: Measurement,
    base: BaseSimulation,
    failures: Sequence[SimulationFailure] | None = None,
) -> list[str]:
    """For each test, readings that the base simulation does not come to, and why.

    Args:
        measurement: all that was measured.
        base: of the readings that it reaches, or of all.
        failures: of the base simulation, where it is of the readings that it reaches.
    """
    every = measurement.listed()["test"].to_numpy()
    reached = base.measurement.listed()["test"].to_numpy()[np.isfinite(base.readings)]
    found = []
    for test in measurement.tests:
        count = int((every == test.number).sum())
        lost = count - int((reached == test.number).sum())
        if lost:
            failed = base.failures if failures is None else failures
            why = [each.sentence for each in failed if test in each.tests]
            found.append(
                f"{test.experiment} of {test.specimen}: the base simulation does not reach "
                f"{lost} of {count} readings, which are left out: {'; '.join(why)}"
            )
    return found


def of_verdict(verdict: Verdict) -> list[str]:
    """The verdict's notes, those of all effects that cannot be seen in one."""
    hidden = [score.name for score in verdict.scores if not score.visible]
    notes = [n for n in verdict.notes if not n.endswith("cannot be seen in these readings")]
    return [*notes, *([f"not to be seen in these readings: {', '.join(hidden)}"] if hidden else [])]


def of_noise(
    verdict: Verdict, under: Mapping[str, Verdict], models: Mapping[str, float]
) -> list[str]:
    """How the verdict depends on the noise."""
    return [
        f"with noise {name} (probability {models[name]:.2f}): {each.sentence()}"
        for name, each in under.items()
        if (each.answer, set(each.names)) != (verdict.answer, set(verdict.names))
    ]

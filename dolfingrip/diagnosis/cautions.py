"""What a diagnosis tells its reader to beware of, a sentence each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.simulated import SimulationFailure

MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as only a graded mesh of hexahedra tells it: it "
    "may be named as an effect; compare readings with a finer mesh (mesh.refine=2, mesh.size_mm)"
)
"""Said where there is no second mesh to compare with."""


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

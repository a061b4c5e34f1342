"""What the simulation says of a measurement as configured, and what else it could say.

    base.readings        # (n,) y0, on the graded mesh
    base.nuisance_list   # changes at one standard deviation, each (n,)
    base.mesh            # (n, 1 or 0) D: 0.3 x (graded - ungraded)
    base.by_control      # (n,) dy/dp: noise of the gauge, in a reading's unit, is dy/dp * sigma_p

n is ``len(measurement.listed())``, with which everything is aligned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import modulus
from dolfingrip.diagnosis.simulation.nuisances import Nuisance
from dolfingrip.diagnosis.simulation.simulated import Simulated, SimulationFailure


@dataclass(frozen=True, slots=True)
class BaseSimulation:
    """What the simulation says as it is configured, and what else it could say.

    Attributes:
        measurement: of all arrays.
        config: without set-ups.
        simulated: on the graded mesh, with derivatives by ``nuisances.keys``.
        nuisance_list: changes at one standard deviation, with their names.
        mesh: (n, 1) what the mesh may get wrong; (n, 0) where it cannot be told.
        plain: on the ungraded mesh, without derivatives; None where there is none.
    """

    measurement: Measurement
    config: Config
    simulated: Simulated
    nuisance_list: Sequence[Nuisance]
    mesh: np.ndarray
    plain: Simulated | None = None

    @property
    def readings(self) -> np.ndarray:
        """(n,) in each column's unit; NaN where the simulation did not come so far."""
        return self.simulated.readings

    @property
    def by_control(self) -> np.ndarray:
        """(n,) change by an error of the gauge, for each kPa or mm; see ``Simulated``."""
        return self.simulated.by_control

    @property
    def failures(self) -> Sequence[SimulationFailure]:
        """Of the base simulation itself."""
        return self.simulated.failures

    @property
    def scales(self) -> bool:
        """Whether a change of all moduli scales the readings exactly."""
        return all(modulus.scales(run.config) for run in self.simulated.runs)


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

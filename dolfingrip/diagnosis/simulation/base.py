"""The base simulation of a measurement, and what its readings can change by.

    base = simulate_base(measurement, config, Workers(folder, Where(workers=2)))
    base.readings        # (n,) y0, on the graded mesh
    base.nuisances       # (n, k) N: changes at one standard deviation
    base.mesh            # (n, 1 or 0) D: 0.3 x (graded - ungraded)
    base.candidates      # a Candidate for each effect that is not on
    base.by_control      # (n,) dy/dp: noise of the gauge, in a reading's unit, is dy/dp * sigma_p
    base.at_modulus(0.9) # (n,) y0 with all moduli 0.9 times as large; exact, no simulation

n is ``len(measurement.listed())``, with which everything is aligned.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import meshes, modulus, secants
from dolfingrip.diagnosis.simulation.nuisances import Nuisance, keys, neutral_stages, nuisances
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.secants import ROUNDING, Candidate
from dolfingrip.diagnosis.simulation.simulated import (
    Case,
    Simulated,
    SimulationFailure,
    simulate,
)


@dataclass(frozen=True, slots=True)
class BaseSimulation:
    """What the simulation says as it is configured, and what else it could say.

    Attributes:
        measurement: of all arrays.
        config: without set-ups and without candidates.
        simulated: on the graded mesh, with derivatives by ``nuisances.keys``.
        nuisance_list: columns of :attr:`nuisances` with their names.
        mesh: (n, 1) what the mesh may get wrong; (n, 0) where it cannot be told.
        candidates: causes that may be named.
        plain: on the ungraded mesh, without derivatives; None where there is none.
    """

    measurement: Measurement
    config: Config
    simulated: Simulated
    nuisance_list: Sequence[Nuisance]
    mesh: np.ndarray
    candidates: Sequence[Candidate]
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
    def nuisances(self) -> np.ndarray:
        """(n, k) changes at one standard deviation of each nuisance."""
        columns = [nuisance.change for nuisance in self.nuisance_list]
        return np.column_stack(columns) if columns else np.zeros((len(self.readings), 0))

    @property
    def failures(self) -> Sequence[SimulationFailure]:
        """Of the base simulation itself."""
        return self.simulated.failures

    @property
    def scales(self) -> bool:
        """Whether :meth:`at_modulus` is exact here; else the nuisance ``modulus`` has to do."""
        return all(modulus.scales(run.config) for run in self.simulated.runs)

    def at_modulus(self, factor: float) -> np.ndarray:
        """(n,) readings with all moduli ``factor`` times as large.

        Raises:
            ValueError: where :attr:`scales` is false.
        """
        return modulus.scaled(self.measurement, self.simulated, factor)


def simulate_base(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    *,
    effects: Collection[str] | None = None,
    same_mesh: bool = False,
) -> BaseSimulation:
    """Simulate a measurement as configured, and with each effect at its ordinary strength.

    Args:
        measurement: whose protocols and set-ups are followed.
        config: the model that is diagnosed; effects that are on in it are part of the base.
        workers: where simulations are computed and kept.
        effects: names of those that are tried; default: the whole catalogue.
        same_mesh: try effects on the graded mesh, too, which takes three times as long.

    Raises:
        ConfigError: one line: a set-up that cannot be built, no workers, or a store in use.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    stages = neutral_stages(config)
    flat = meshes.ungraded(config)
    mesh = () if same_mesh else flat
    lab = _heaviest(measurement, config)
    tried = secants.tried_effects(lab, effects)
    wanted = [
        Case(stages, keys(measurement, config), headroom=True),
        *([Case(flat)] if flat else []),
    ]
    own = [secants.cases(each, lab, mesh) for each in tried]
    found = simulate(measurement, config, [*wanted, *(c for row in own for c in row)], workers)
    graded, plain = found[0], found[len(wanted) - 1]
    beside = plain if mesh else graded
    later = iter(found[len(wanted) :])
    candidates = [
        secants.candidate(
            measurement, config, each, graded, beside, [next(later) for _ in row],
            "ungraded" if mesh else "graded",
        )
        for each, row in zip(tried, own, strict=True)
    ]  # fmt: skip
    error = meshes.SHARE * (graded.readings - plain.readings)[:, None]
    return BaseSimulation(
        measurement,
        config,
        graded,
        nuisances(measurement, graded),
        error if np.nanmax(np.abs(error), initial=0.0) > ROUNDING else error[:, :0],
        candidates,
        plain if flat else None,
    )


def _heaviest(measurement: Measurement, config: Config) -> Config:
    """The configuration of a test, of one with weight where there is any."""
    every = [test.setup.applied(config) for test in measurement.tests]
    return max(every, key=lambda applied: applied.gravity.acceleration_m_s2)

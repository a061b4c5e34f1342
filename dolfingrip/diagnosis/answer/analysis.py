"""An analysis: readings with all that could explain them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.numbers import Cause
from dolfingrip.diagnosis.core.problem import InferenceProblem
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion


class Simulation(Protocol):
    """The simulation of a measurement."""

    measurement: Measurement


@dataclass(frozen=True, eq=False)
class Analysis[S: Simulation](ABC):
    """Everything that the inference needs of coupons, or of fingers.

    Attributes:
        problem: readings, emulators and covariance.
        causes: by name.
        errors: what the covariance is made of.
        simulation: of the model.
        unseen: causes that no reading feels.
        failed: why others could not be simulated, by name.
        implausible: numbers of the rig that may be implausible and are no effects, by name.
        not_reached: tests with readings that the model does not reach, and why.
    """

    problem: InferenceProblem
    causes: dict[str, Cause]
    errors: Errors
    simulation: S
    unseen: Sequence[str]
    failed: Mapping[str, str] = field(default_factory=dict)
    implausible: Mapping[str, Cause] = field(default_factory=dict)
    not_reached: Sequence[str] = ()

    @property
    def measurement(self) -> Measurement:
        """The readings, and how they were taken."""
        return self.simulation.measurement

    @property
    def scaled(self) -> np.ndarray:
        """(n,) whether a reading is proportional to the moduli."""
        return in_proportion(self.measurement)

    def factor(self, fit: MapFit) -> float:
        """Return the factor of all moduli, by those configured."""
        return float(self.problem.factor(fit.zeta[0]))

    def at(self, fit: MapFit, factor: float) -> dict[str, Any]:
        """Return the change to the causes of a fit, their moduli times a factor."""
        places = self.problem.places(fit.subset)
        found: dict[str, Any] = {}
        for name in fit.subset:
            if name in self.causes:
                found |= self.causes[name].overrides(fit.zeta[places[name]], factor)
        return found

    def emulator_error(self, fit: MapFit, exact: np.ndarray) -> float:
        """Largest difference of the emulators at a fit from exact readings, (n,), by the noise."""
        missed = exact - self.problem.predicted(fit.subset, fit.zeta)
        return float(np.abs(missed / self.errors.noise).max())

    @abstractmethod
    def exact(self, fit: MapFit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""

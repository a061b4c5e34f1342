"""What an answer is about: readings with all that could explain them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core.case import Case
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.numbers import Cause
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion


class Simulation(Protocol):
    """What simulates a measurement."""

    measurement: Measurement


@dataclass(frozen=True, eq=False)
class Analysed[S: Simulation](ABC):
    """Everything that the inference needs of coupons, or of fingers.

    Attributes:
        case: readings, emulators and covariance.
        causes: by name.
        errors: what the covariance is made of.
        simulation: of the model.
        unseen: causes that no reading feels.
        failed: why others could not be simulated, by name.
        far: numbers of the rig that may be far from what was told and are no effects, by name.
        not_reached: tests with readings that the model does not reach, and why.
    """

    case: Case
    causes: dict[str, Cause]
    errors: Errors
    simulation: S
    unseen: Sequence[str]
    failed: Mapping[str, str] = field(default_factory=dict)
    far: Mapping[str, Cause] = field(default_factory=dict)
    not_reached: Sequence[str] = ()

    @property
    def measurement(self) -> Measurement:
        """The readings, and how they were taken."""
        return self.simulation.measurement

    @property
    def scaled(self) -> np.ndarray:
        """(n,) whether a reading is proportional to the moduli."""
        return in_proportion(self.measurement)

    def factor(self, fit: Fit) -> float:
        """Of all moduli, by those configured."""
        return float(self.case.factor(fit.zeta[0]))

    def at(self, fit: Fit, factor: float) -> dict[str, Any]:
        """Return the change to the causes of a fit, their moduli times a factor."""
        places = self.case.places(fit.subset)
        found: dict[str, Any] = {}
        for name in fit.subset:
            if name in self.causes:
                found |= self.causes[name].overrides(fit.zeta[places[name]], factor)
        return found

    @abstractmethod
    def exact(self, fit: Fit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""

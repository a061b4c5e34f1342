"""The work that the pressure has done on an elastic body."""

from __future__ import annotations

import numpy as np

from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.readings.reading import Reading

COLUMN = "work_mJ"


class PressureWork(Reading):
    """W = ∫ p dV along the way to the present state, of the whole solid (mJ).

    Where nothing is dissipated, the work is what all terms of the potential but the pressure's
    store: W = Π + p V, whatever the way. It counts from the state at rest.

    Args:
        model: under pressure control, elastic.
        volume: reading of the cavity's volume (mm³).
        cavity: the cavity's pressure.
    """

    def __init__(self, model: Model, volume: Reading, cavity: Control) -> None:
        super().__init__(model, COLUMN)
        self._volume, self._cavity = volume, cavity

    @property
    def _pressure_MPa(self) -> float:
        return float(self._cavity.constant.value)

    def value(self) -> float:
        stored = self.model.domain.copies * self.model.energy()
        return float(stored + self._pressure_MPa * self._volume.value())

    def gradient(self) -> np.ndarray:
        copies = self.model.domain.copies
        stored = copies * self.model.gradient(supported=False)
        return np.asarray(stored + self._pressure_MPa * self._volume.gradient())

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        copies, pressure = float(self.model.domain.copies), self._pressure_MPa
        stored, enclosed = ShapeGradient(gradient.coordinates), ShapeGradient(gradient.coordinates)
        for term in self.model.all_terms:
            term.add_shape_gradient(self.model.u.x.array, stored)
        self._volume.add_shape_gradient(enclosed)
        gradient.add(stored, copies)
        gradient.add(enclosed, pressure)

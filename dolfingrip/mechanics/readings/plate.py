"""Readings of the force-sensor plate."""

from __future__ import annotations

import numpy as np

from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.direction import Direction
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.integrals import Integral
from dolfingrip.mechanics.readings.reading import Reading


class PlateForce(Integral):
    """Normal force on the whole finger's plate (N)."""

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, "force_N", plate.reaction)


class PlateGap(Reading):
    """Smallest distance of the skin's nodes from the plate (mm)."""

    differentiable = False

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, "plate_gap_mm")
        self._plate = plate

    def value(self) -> float:
        return self._plate.gap_mm()


class PlatePlace(Reading):
    """Where the plate is put against the present pose, along its normal (mm).

    Its derivatives are those of the skin's nearest node.
    """

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, "plate_place_mm")
        self._plate = plate

    def value(self) -> float:
        return self._plate.place_mm()

    def gradient(self) -> np.ndarray:
        found = Gradient(self.model.unknowns)
        node = self._plate.nearest_node()
        if node is not None:
            found.at_nodes[node] = self._plate.normal
        return found.array

    def by_direction(self, direction: Direction) -> float:
        if direction.velocity is None:
            return 0.0
        return self._plate.place_rate(direction.velocity)

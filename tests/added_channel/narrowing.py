"""By how much a bar narrows: a reading that only the test of added channels has."""

from __future__ import annotations

import numpy as np

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading


class Narrowing(Reading):
    """Width along x at rest, less that between the mean places of the nodes of both sides (mm)."""

    def __init__(self, model: Model) -> None:
        super().__init__(model, "narrowing_mm")
        x = model.u.function_space.tabulate_dof_coordinates()[:, 0]
        sides = [np.isclose(x, at) for at in (x.min(), x.max())]
        lower, upper = (side / side.sum() for side in sides)
        self._weights = lower - upper

    def value(self) -> float:
        return float(self._weights @ self.model.u.x.array.reshape(-1, 3)[:, 0])

    def gradient(self) -> np.ndarray:
        found = Gradient(self.model.unknowns)
        found.at_nodes[:, 0] += self._weights
        return found.array

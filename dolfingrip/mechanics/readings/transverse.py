"""The transverse strain of a bar that is pulled."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from dolfingrip.channels import TRANSVERSE_STRAIN
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading

AXIS = 0
"""Axis of the width."""


class TransverseStrain(Reading):
    """Nominal strain across a bar: the ratio of its width and its width at rest, less 1 (no unit).

    The width is the distance along x between the mean places of nodes on two opposite sides, at the
    nodes nearest to half the length along z. A camera sees this width in the bar's outline. (ISO
    527-1 calls its ratio to the strain along the bar, with a minus sign, Poisson's ratio.)
    """

    def __init__(self, model: Model) -> None:
        super().__init__(model, TRANSVERSE_STRAIN.name)
        self._weights = _weights(model)

    def _apart(self, at_nodes: np.ndarray) -> float:
        """Difference of the means of a field (nodes, 3) on the two sides, along the axis."""
        local = float(self._weights @ at_nodes[: len(self._weights), AXIS])
        return float(self.model.comm.allreduce(local, MPI.SUM))

    def _width_mm(self) -> float:
        return self._apart(self.model.u.function_space.tabulate_dof_coordinates())

    def value(self) -> float:
        return self._apart(self.model.u.x.array.reshape(-1, 3)) / self._width_mm()

    def add_gradient(self, gradient: Gradient) -> None:
        gradient.at_nodes[:, AXIS] += self._weights / self._width_mm()


def _weights(model: Model) -> np.ndarray:
    """Weights of this rank's nodes in the upper side's mean less the lower's, near the middle."""
    low, high = model.box_mm
    part = (model.nodes_mm - low) / (high - low)
    away = np.abs(part[:, 2] - 0.5)
    nearest = model.comm.allreduce(float(away.min(initial=np.inf)), MPI.MIN)
    middle = np.isclose(away, nearest)
    sides = np.array([middle & np.isclose(part[:, AXIS], at) for at in (0.0, 1.0)])
    counts = model.comm.allreduce(sides.sum(axis=1), MPI.SUM)
    return np.asarray(np.array([-1.0, 1.0]) / counts @ sides)

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
        self._sides = _sides(model)
        self._counts = [model.comm.allreduce(len(nodes), MPI.SUM) for nodes in self._sides]

    def _apart(self, at_nodes: np.ndarray) -> float:
        """Difference of the means of a field (nodes, 3) on the two sides, along the axis."""
        local = sum(
            sign * float(at_nodes[nodes, AXIS].sum()) / count
            for sign, nodes, count in self._weights()
        )
        return float(self.model.comm.allreduce(local, MPI.SUM))

    def _weights(self) -> list[tuple[float, np.ndarray, int]]:
        return list(zip((-1.0, 1.0), self._sides, self._counts, strict=True))

    def _width_mm(self) -> float:
        return self._apart(self.model.u.function_space.tabulate_dof_coordinates())

    def value(self) -> float:
        return self._apart(self.model.u.x.array.reshape(-1, 3)) / self._width_mm()

    def add_gradient(self, gradient: Gradient) -> None:
        width_mm = self._width_mm()
        for sign, nodes, count in self._weights():
            gradient.at_nodes[nodes, AXIS] += sign / (count * width_mm)


def _sides(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """This rank's owned displacement nodes on the lower and on the upper side, near the middle."""
    low, high = model.box_mm
    part = (model.nodes_mm - low) / (high - low)
    away = np.abs(part[:, 2] - 0.5)
    nearest = model.comm.allreduce(float(away.min(initial=np.inf)), MPI.MIN)
    middle = np.isclose(away, nearest)
    lower, upper = (np.flatnonzero(middle & np.isclose(part[:, AXIS], at)) for at in (0.0, 1.0))
    return lower, upper

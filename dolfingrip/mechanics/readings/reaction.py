"""The force that supports bear."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.readings.integrals import Integral


class Reaction(Integral):
    """Sum of the supports' forces on some nodes along an axis (N), for the whole solid.

    It is the residual R(u; w) with the test function w = 1 at these nodes, and so it has that
    form's derivatives; further terms of Π must not act on these nodes.

    Args:
        model: model that is read.
        column: name in the table.
        nodes: this rank's owned displacement nodes.
        axis: 0, 1 or 2.
    """

    def __init__(self, model: Model, column: str, nodes: np.ndarray, axis: int) -> None:
        chosen = fem.Function(model.u.function_space)
        chosen.x.array[3 * nodes + axis] = 1.0
        chosen.x.scatter_forward()
        super().__init__(model, column, ufl.action(model.potential.gradient, chosen))
        self._nodes, self._axis = nodes, axis

    def value(self) -> float:
        local = float(self.model.reactions()[self._nodes, self._axis].sum())
        return float(self.model.domain.copies * self.model.comm.allreduce(local, MPI.SUM))

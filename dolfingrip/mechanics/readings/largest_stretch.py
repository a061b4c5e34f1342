"""The largest principal stretch at the integration points of a solid."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from dolfingrip.forms.kinematics import deformation_gradient
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.points import AtPoints


class LargestStretch:
    """The largest principal stretch (–) at the present state.

    Args:
        model: model that is read.
        degree: degree of the integration rule.
        cells: this rank's cells that are looked at; None: all.
    """

    def __init__(self, model: Model, degree: int, cells: np.ndarray | None = None) -> None:
        f = deformation_gradient(model.u)
        self._comm = model.comm
        self._right = AtPoints(f.T * f, model.domain.mesh, degree, cells)

    def value(self) -> float:
        """The stretch, equal on all ranks."""
        values = self._right.values().reshape(-1, 3, 3)
        here = float(np.sqrt(np.linalg.eigvalsh(values)[:, -1].max())) if len(values) else 1.0
        return float(self._comm.allreduce(here, MPI.MAX))

"""Readings of the force-sensor plate."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from dolfingrip.channels import FORCE, PLATE_GAP
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading


class PlateForce(Reading):
    """Normal force on the whole finger's plate (N)."""

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, FORCE.name)
        self._plate = plate

    def value(self) -> float:
        return self._plate.force_N()

    def gradient(self) -> np.ndarray:
        found, load = Gradient(self.model.unknowns), self._plate.reaction
        dofs, copies = self.model.u.x.array, self.model.domain.copies
        found.fields[0][:] = copies * load.by_displacement(dofs)
        for unknown in self.model.unknowns.global_unknowns:
            found.add(unknown, copies * self._sum(load.by_constant(dofs, unknown.constant)))
        return found.array

    def _sum(self, own: float) -> float:
        return float(self.model.comm.allreduce(own, MPI.SUM))


class PlateGap(Reading):
    """Smallest distance of the skin's nodes from the plate (mm)."""

    differentiable = False

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, PLATE_GAP.name)
        self._plate = plate

    def value(self) -> float:
        return self._plate.gap_mm()

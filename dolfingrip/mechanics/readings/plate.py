"""Readings of the force-sensor plate."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from dolfingrip.channels import FORCE, PLATE_GAP
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading


class PlateForce(Reading):
    """Normal force on the whole finger's plate (N): that on the meshed part is ∂Π/∂(offset)."""

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, FORCE.name)
        self._plate = plate

    def value(self) -> float:
        return self._plate.force_N()

    def add_gradient(self, gradient: Gradient) -> None:
        plate, dofs, copies = self._plate, self.model.u.x.array, self.model.domain.copies
        gradient.at_nodes[:] = copies * plate.pose_rate(dofs, plate.motion)
        by_pose = self.model.comm.allreduce(plate.motion @ plate.pose_curvature(dofs), MPI.SUM)
        for unknown in self.model.unknowns.global_unknowns:
            gradient.add(unknown, copies * float(by_pose @ plate.pose.rate(unknown.constant)))

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        plate, copies = self._plate, float(self.model.domain.copies)
        plate.add_load_shape_gradient(self.model.u.x.array, plate.motion, gradient, copies)


class PlatePlace(Reading):
    """Where the plate would stand at its gap from the present shape (mm along its normal).

    The nearest nodes decide it. Where several are equally near, as on a flat side, each has an
    equal share in the derivatives, which is right for motions that keep the side flat.
    """

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, "plate_place_mm")
        self._plate = plate

    def value(self) -> float:
        return self._plate.place_mm()

    def _shares(self) -> tuple[np.ndarray, np.ndarray]:
        """This rank's nearest nodes, and the derivatives (n, 3) by their places in its axes."""
        rows = self._plate.nearest()
        count = self.model.comm.allreduce(len(rows), MPI.SUM)
        points = self._plate.points
        normals = np.tile(self._plate.normal / max(count, 1), (len(rows), 1))
        return points.nodes[rows], points.to_reference(normals, rows)

    def add_gradient(self, gradient: Gradient) -> None:
        nodes, shares = self._shares()
        gradient.at_nodes[nodes] += shares

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        nodes, shares = self._shares()
        gradient.at_nodes[nodes] += shares


class PlateGapReading(Reading):
    """Smallest distance of the skin's nodes from the plate (mm)."""

    differentiable = False

    def __init__(self, model: Model, plate: RigidPlate) -> None:
        super().__init__(model, PLATE_GAP.name)
        self._plate = plate

    def value(self) -> float:
        return self._plate.gap_mm()

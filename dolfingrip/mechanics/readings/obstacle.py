"""Readings of the pressure on what stands beside a finger: force, area, mean and spread."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from mpi4py import MPI

from dolfingrip.channels import OBSTACLE
from dolfingrip.mechanics.contact.pose_contact import Near
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading

KPA_IN_MPA: Final = 1e3

Function = Callable[[float, float, float], tuple[float, tuple[float, float, float]]]
"""From the area (mm²), ∫ p dA (N) and ∫ p² dA (N MPa) to a number and its derivatives."""


def _mean(area: float, force: float, _: float) -> tuple[float, tuple[float, float, float]]:
    if not area:
        return 0.0, (0.0, 0.0, 0.0)
    mean = KPA_IN_MPA * force / area
    return mean, (-mean / area, KPA_IN_MPA / area, 0.0)


def _spread(area: float, force: float, square: float) -> tuple[float, tuple[float, float, float]]:
    """Return √(A ∫ p² dA / (∫ p dA)² − 1)."""
    if not force:
        return 0.0, (0.0, 0.0, 0.0)
    ratio = area * square / force**2
    found = math.sqrt(max(ratio - 1, np.finfo(float).tiny))
    slopes = square / force**2, -2 * ratio / force, area / force**2
    return found, (slopes[0] / 2 / found, slopes[1] / 2 / found, slopes[2] / 2 / found)


FUNCTIONS: Final[tuple[Function, ...]] = (
    lambda area, force, square: (force, (0.0, 1.0, 0.0)),
    lambda area, force, square: (area, (1.0, 0.0, 0.0)),
    _mean,
    _spread,
)
"""Of each channel."""


class OnObstacle(Reading):
    """A number of the contact pressures p, each with a share of the skin's area at rest.

    It has derivatives away from states in which a point comes to touch or leaves.

    Args:
        model: of a finger.
        contact: with the obstacle.
        column: name in the table.
        function: of the integrals over the part of the skin that presses.
    """

    def __init__(
        self, model: Model, contact: RigidContact, column: str, function: Function
    ) -> None:
        super().__init__(model, column)
        self._contact, self._function = contact, function

    def _here(self) -> tuple[Near, float, tuple[float, float, float]]:
        """Points that press, the number, and its derivatives by the three integrals."""
        near = self._contact.near(self.model.u.x.array)
        pressure = -near.barrier.slope
        each = near.areas * np.stack([pressure > 0, pressure, pressure**2])
        sums = self.model.comm.allreduce(each.sum(axis=1), MPI.SUM)
        area, force, square = (self.model.domain.copies * sums).tolist()
        return near, *self._function(area, force, square)

    def value(self) -> float:
        return self._here()[1]

    def _by_points(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, derivatives by their areas, and (n, 3) by their places in the world."""
        near, _, slopes = self._here()
        by_area, by_force, by_square = self.model.domain.copies * np.array(slopes)
        pressure = -near.barrier.slope
        densities = by_area * (pressure > 0) + by_force * pressure + by_square * pressure**2
        rates = -(by_force + 2 * by_square * pressure) * near.areas * near.barrier.curvature
        normals = near.distances.gradient @ near.turned.matrix
        return near.rows, densities, rates[:, None] * normals

    def gradient(self) -> np.ndarray:
        found, points = Gradient(self.model.unknowns), self._contact.points
        rows, _, forces = self._by_points()
        found.at_nodes[points.nodes[rows]] += points.to_reference(forces, rows)
        return found.array

    def add_shape_gradient(self, found: ShapeGradient) -> None:
        rows, densities, forces = self._by_points()
        self._contact.points.add_shape_gradient(found, rows, densities, forces)


def on_obstacle(model: Model, contact: RigidContact) -> list[Reading]:
    """Make the readings of a contact with an obstacle.

    Args:
        model: of a finger.
        contact: with the obstacle.

    Returns:
        One reading for each of :data:`~dolfingrip.channels.OBSTACLE`.
    """
    each = zip(OBSTACLE, FUNCTIONS, strict=True)
    return [OnObstacle(model, contact, channel.name, function) for channel, function in each]

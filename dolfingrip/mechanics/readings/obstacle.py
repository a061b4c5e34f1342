"""Readings of the pressure on what stands beside a finger: force, area, mean, lift and spread."""

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

Four = tuple[float, float, float, float]

NONE: Final[Four] = (0.0, 0.0, 0.0, 0.0)

Function = Callable[[float, float, float, float], tuple[float, Four]]
"""From the area (mm²), ∫ p dA (N), ∫ p² dA (N MPa) and the lift (N) to a number and its derivatives
by them."""


TOUCHES: Final = 0.2
"""Pressure from which on a place counts as touching, by the mean over the force, ∫ p² / ∫ p. A
barrier is felt before bodies touch, so places of less pressure count in part."""


def _share(pressure: np.ndarray) -> np.ndarray:
    """Parts of places that touch, by their pressures as parts of that which touches."""
    parts = np.clip(pressure, 0, 1)
    return np.asarray(parts**2 * (3 - 2 * parts))


def _mean(area: float, force: float, square: float, lift: float) -> tuple[float, Four]:
    if not area:
        return 0.0, NONE
    mean = KPA_IN_MPA * force / area
    return mean, (-mean / area, KPA_IN_MPA / area, 0.0, 0.0)


def _spread(area: float, force: float, square: float, lift: float) -> tuple[float, Four]:
    """Return √(A ∫ p² dA / (∫ p dA)² − 1)."""
    if not force:
        return 0.0, NONE
    ratio = area * square / force**2
    spread = math.sqrt(max(ratio - 1, np.finfo(float).tiny))
    slopes = square / force**2, -2 * ratio / force, area / force**2
    return spread, (slopes[0] / 2 / spread, slopes[1] / 2 / spread, slopes[2] / 2 / spread, 0.0)


FUNCTIONS: Final[tuple[Function, ...]] = (
    lambda area, force, square, lift: (force, (0.0, 1.0, 0.0, 0.0)),
    lambda area, force, square, lift: (area, (1.0, 0.0, 0.0, 0.0)),
    _mean,
    lambda area, force, square, lift: (lift, (0.0, 0.0, 0.0, 1.0)),
    _spread,
)
"""Of each channel."""


class OnObstacle(Reading):
    """A number of the contact pressures p, each with a share of the skin's area at rest.

    It has derivatives away from states in which a point comes to touch or leaves. With the normal n
    away from the body a pressure p and friction μ bear p (n_z + μ √(1 − n_z²)) towards the clamp.

    Args:
        model: of a finger.
        contact: with the obstacle.
        column: name in the table.
        function: of the integrals over the part of the skin that presses.
        friction: μ.
    """

    def __init__(
        self,
        model: Model,
        contact: RigidContact,
        column: str,
        function: Function,
        friction: float,
    ) -> None:
        super().__init__(model, column)
        self._contact, self._function, self._friction = contact, function, friction

    def _bears(self, near: Near) -> tuple[np.ndarray, np.ndarray]:
        """The lift for each unit of pressure (n,), and its derivatives by places, (n, 3)."""
        turn = near.turned.matrix
        up = (near.distances.gradient @ turn)[:, 2]
        along = np.sqrt(np.maximum(1 - up**2, np.finfo(float).tiny))
        turning = np.einsum("ji,njl,l->ni", turn, near.distances.hessian, turn[:, 2])
        by_up = 1 - self._friction * up / along
        return up + self._friction * along, by_up[:, None] * turning

    def _here(self) -> tuple[Near, float, Four, float]:
        """Points that press, the number, its derivatives by the integrals, and what touches (MPa).

        What touches is the pressure from which on a place counts as touching.
        """
        near = self._contact.near(self.model.u.x.array)
        pressure = -near.barrier.slope
        lift = pressure * self._bears(near)[0]
        force, square, lift = self._sums(near.areas * np.stack([pressure, pressure**2, lift]))
        touching = TOUCHES * square / force if force else 1.0
        (area,) = self._sums(near.areas * _share(pressure / touching)[None])
        return near, *self._function(area, force, square, lift), touching

    def _sums(self, rows: np.ndarray) -> list[float]:
        """Sums of rows over the points of all ranks, of the whole finger."""
        sums = self.model.comm.allreduce(rows.sum(axis=1), MPI.SUM)
        return (self.model.domain.copies * sums).tolist()

    def value(self) -> float:
        return self._here()[1]

    def _by_points(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, derivatives by their areas, and (n, 3) by their places in the world."""
        near, _, slopes, touching = self._here()
        by_area, by_force, by_square, by_lift = self.model.domain.copies * np.array(slopes)
        pressure, (bears, turning) = -near.barrier.slope, self._bears(near)
        parts = np.clip(pressure / touching, 0, 1)
        rising = 6 * parts * (1 - parts)
        integrands = near.areas * np.stack([pressure, pressure**2, rising * parts])
        force, square, passed = self._sums(integrands)
        if force:  # what touches rises with the pressures
            by_force += by_area * passed / force
            by_square -= by_area * passed / square
        densities = by_area * _share(parts) + by_square * pressure**2
        densities += (by_force + by_lift * bears) * pressure
        by_pressure = by_force + 2 * by_square * pressure + by_lift * bears
        by_pressure += by_area * rising / touching
        rates = -by_pressure * near.areas * near.barrier.curvature
        forces = rates[:, None] * (near.distances.gradient @ near.turned.matrix)
        forces += (by_lift * near.areas * pressure)[:, None] * turning
        return near.rows, densities, forces

    def add_gradient(self, gradient: Gradient) -> None:
        points = self._contact.points
        rows, _, forces = self._by_points()
        gradient.at_nodes[points.nodes[rows]] += points.to_reference(forces, rows)

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        rows, densities, forces = self._by_points()
        self._contact.points.add_shape_gradient(gradient, rows, densities, forces)


def on_obstacle(model: Model, contact: RigidContact, friction: float) -> list[Reading]:
    """Make the readings of a contact with an obstacle.

    Args:
        model: of a finger.
        contact: with the obstacle.
        friction: of the finger on it, which the lift counts with.

    Returns:
        One reading for each of :data:`~dolfingrip.channels.OBSTACLE`.
    """
    pairs = zip(OBSTACLE, FUNCTIONS, strict=True)
    return [
        OnObstacle(model, contact, channel.name, function, friction) for channel, function in pairs
    ]

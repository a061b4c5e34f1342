"""A force between a surface and a rigid body as a reading, with its derivatives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from dolfinx import fem

from dolfingrip.mechanics.model.shape_gradient import ShapeGradient

if TYPE_CHECKING:
    from dolfingrip.mechanics.contact.rigid import RigidContact


class Load:
    """g = e · ∂Π/∂q: the force that holds a rigid body along a motion e of its pose q.

    It is the meshed part's share. Each derivative is this rank's share.

    Args:
        contact: contact with the body.
        motion: (6,) e; with (n, 0), g is the force along n.
    """

    def __init__(self, contact: RigidContact, motion: np.ndarray) -> None:
        self._contact = contact
        self._motion = np.asarray(motion, dtype=float)

    def by_displacement(self, dofs: np.ndarray) -> np.ndarray:
        """Derivatives by the owned displacements, in the order of a vector."""
        return self._contact.pose_rate(dofs, self._motion).ravel()

    def add_shape_gradient(self, dofs: np.ndarray, found: ShapeGradient, factor: float) -> None:
        """Add ``factor`` times the derivatives by the reference coordinates."""
        self._contact.add_load_shape_gradient(dofs, self._motion, found, factor)

    def by_constant(self, dofs: np.ndarray, constant: fem.Constant) -> float:
        """Derivative by one of the pose's coordinates; 0 by any other constant."""
        rate = self._contact.pose.rate(constant)
        return float(self._motion @ self._contact.pose_curvature(dofs) @ rate)

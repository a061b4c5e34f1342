"""The stress as an independent field at the integration points."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.mechanics import points


class CarriedStress:
    """Second Piola–Kirchhoff stress (MPa) that follows Newton's steps linearly.

    After a step w from u the stress becomes S(E(u)) + C(E(u)) : sym(Fᵀ∇w), where plain Newton
    takes S(E(u + w)). Used in the geometric part of the tangent only, so a converged solution
    does not depend on it; large rotations no longer spoil the stress between iterations
    (Magisano, Leonetti & Garcea 2017; Pfefferkorn, Bieber, Oesterle, Bischoff & Betsch, 2021).

    Attributes:
        stress: (3, 3) at each integration point.
    """

    def __init__(self, u: fem.Function, stress: Expr, degree: int) -> None:
        mesh = u.function_space.mesh
        self.stress = points.field(mesh, (3, 3), degree, "carried_stress_MPa")
        self._step = fem.Function(u.function_space)
        predicted = stress + ufl.derivative(stress, u, self._step)
        self._now = points.AtPoints(stress, mesh, degree)
        self._after = points.AtPoints(predicted, mesh, degree)

    def reset(self) -> None:
        """Set to S(E(u))."""
        self._now.into(self.stress)

    def follow(self, step: np.ndarray) -> None:
        """Set to the linear prediction for ``step`` (local dofs, mm) from the present u."""
        self._step.x.array[:] = step
        self._after.into(self.stress)

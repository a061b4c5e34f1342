"""The stress as an independent field at the integration points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule
from dolfingrip.mechanics.model import points


class CarriedStress:
    """Second Piola–Kirchhoff stress (MPa) that follows Newton's steps linearly.

    After a step w from u the stress becomes S(E(u)) + C(E(u)) : sym(Fᵀ∇w), where plain Newton
    takes S(E(u + w)). Used in the geometric part of the tangent only, so a converged solution
    does not depend on it; large rotations no longer spoil the stress between iterations
    (Magisano, Leonetti & Garcea 2017; Pfefferkorn, Bieber, Oesterle, Bischoff & Betsch, 2021).

    Attributes:
        stress: (3, 3) at each integration point.

    Args:
        fields: what the stress depends on: displacement, and the pressure of a mixed model.
        stresses: S in UFL, and the cells where it is such (all where None), part by part.
        degree: of the integration rule.
    """

    def __init__(
        self,
        fields: Sequence[fem.Function],
        stresses: Sequence[tuple[Expr, np.ndarray | None]],
        degree: int,
    ) -> None:
        mesh = fields[0].function_space.mesh
        self.stress = points.field(mesh, (3, 3), degree, "carried_stress_MPa")
        self._steps = [fem.Function(field.function_space) for field in fields]
        self._now, self._after = [], []
        for stress, cells in stresses:
            predicted = stress
            for field, step in zip(fields, self._steps, strict=True):
                predicted = predicted + chain_rule.along(stress, field, step)
            self._now.append(points.AtPoints(stress, mesh, degree, cells))
            self._after.append(points.AtPoints(predicted, mesh, degree, cells))

    def reset(self) -> None:
        """Set to S(E(u))."""
        for part in self._now:
            part.into(self.stress)

    def follow(self, *steps: np.ndarray) -> None:
        """Set to the linear prediction for ``steps`` (local dofs of each field) from here."""
        for holder, step in zip(self._steps, steps, strict=True):
            holder.x.array[:] = step
        for part in self._after:
            part.into(self.stress)

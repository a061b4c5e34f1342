"""The stress as an independent field at the integration points."""

from __future__ import annotations

from collections.abc import Sequence

import basix
import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.mechanics import jit


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
        stress: S in UFL.
        degree: of the integration rule.
    """

    def __init__(self, fields: Sequence[fem.Function], stress: Expr, degree: int) -> None:
        mesh = fields[0].function_space.mesh
        cell = mesh.basix_cell()
        element = basix.ufl.quadrature_element(cell, value_shape=(3, 3), degree=degree)
        self.stress = fem.Function(fem.functionspace(mesh, element), name="carried_stress_MPa")
        self._steps = [fem.Function(field.function_space) for field in fields]
        points = basix.make_quadrature(cell, degree)[0]
        predicted = stress
        for field, step in zip(fields, self._steps, strict=True):
            predicted = predicted + ufl.derivative(stress, field, step)
        self._now = fem.Expression(stress, points, jit_options=jit.options())
        self._after = fem.Expression(predicted, points, jit_options=jit.options())
        cells = mesh.topology.index_map(3).size_local
        self._cells = np.arange(cells, dtype=np.int32)

    def reset(self) -> None:
        """Set to S(E(u))."""
        self._evaluate(self._now)

    def follow(self, *steps: np.ndarray) -> None:
        """Set to the linear prediction for ``steps`` (local dofs of each field) from here."""
        for holder, step in zip(self._steps, steps, strict=True):
            holder.x.array[:] = step
        self._evaluate(self._after)

    def _evaluate(self, expression: fem.Expression) -> None:
        # a quadrature element numbers its dofs cell by cell, in the order of the evaluation
        values = expression.eval(self.stress.function_space.mesh, self._cells)
        self.stress.x.array[: values.size] = values.ravel()

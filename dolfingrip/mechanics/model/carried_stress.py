"""Fields beside the unknowns that a tangent depends on, as the stress at integration points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule
from dolfingrip.mechanics.model import points
from dolfingrip.mechanics.model.points import AtPoints, Rule


class CarriedStress:
    """Second Piola–Kirchhoff stress (MPa) that follows Newton's steps linearly.

    After a step w from u the stress becomes S(E(u)) + C(E(u)) : sym(Fᵀ∇w), where plain Newton
    takes S(E(u + w)). Only the geometric part of the tangent uses it, so a converged solution
    does not depend on it; large rotations no longer spoil the stress between iterations
    (Magisano, Leonetti & Garcea 2017; Pfefferkorn, Bieber, Oesterle, Bischoff & Betsch, 2021).

    It is False where nothing is carried.

    Attributes:
        of_parts: field (3, 3) of each part at its integration points; parts without a rule of their
            own share one.

    Args:
        fields: fields that the stress depends on: displacement, and a mixed model's pressure.
        stresses: of each part S in UFL (MPa; of a sheet N/mm), the cells where it is such (None:
            all), and the integration rule, or its degree (None: that of the volume).
        degree: degree of the volume's integration rule.
    """

    def __init__(
        self,
        fields: Sequence[fem.Function],
        stresses: Sequence[tuple[Expr, np.ndarray | None, Rule | int | None]],
        degree: int,
    ) -> None:
        mesh = fields[0].function_space.mesh
        volume = points.field(mesh, (3, 3), degree, "carried_stress_MPa")
        self._steps = [fem.Function(field.function_space) for field in fields]
        self._now: list[tuple[AtPoints, fem.Function]] = []
        self._after: list[tuple[AtPoints, fem.Function]] = []
        for stress, cells, rule in stresses:
            held = volume
            if rule is not None:
                held = points.field(mesh, (3, 3), rule, "carried_stress_N_per_mm")
            predicted = stress
            for field, step in zip(fields, self._steps, strict=True):
                predicted = predicted + chain_rule.along(stress, field, step)
            self._now.append((AtPoints(stress, mesh, rule or degree, cells), held))
            self._after.append((AtPoints(predicted, mesh, rule or degree, cells), held))
        self.of_parts = [held for _, held in self._now]
        self._arrays = list({id(held): held.x.array for held in self.of_parts}.values())

    def __bool__(self) -> bool:
        return bool(self.of_parts)

    @property
    def values(self) -> np.ndarray:
        """All carried stresses as one array, a copy."""
        return np.concatenate([np.empty(0), *self._arrays])

    @values.setter
    def values(self, values: np.ndarray) -> None:
        ends = np.cumsum([array.size for array in self._arrays])
        for array, part in zip(self._arrays, np.split(values, ends[:-1]), strict=False):
            array[:] = part

    def compile(self) -> None:
        """Compile all expressions."""
        for part, _ in (*self._now, *self._after):
            _ = part.compiled

    def reset(self) -> None:
        """Set to S(E(u))."""
        for part, held in self._now:
            part.into(held)

    def follow(self, *steps: np.ndarray) -> None:
        """Set to the linear prediction for ``steps`` (local dofs of each field) from here."""
        for holder, step in zip(self._steps, steps, strict=True):
            holder.x.array[:] = step
        for part, held in self._after:
            part.into(held)

"""Fields beside the unknowns that a tangent depends on, as the stress at integration points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule
from dolfingrip.mechanics.model import points
from dolfingrip.mechanics.model.points import AtPoints, Rule


class Carried(Protocol):
    """Fields in a term's tangent that are carried along Newton's steps."""

    @property
    def values(self) -> np.ndarray:
        """All of them as one array, a copy."""
        ...

    @values.setter
    def values(self, values: np.ndarray) -> None: ...

    def reset(self) -> None:
        """Set the fields to the values that follow from the present unknowns."""
        ...

    def follow(self, *steps: np.ndarray) -> None:
        """Predict them for ``steps`` (local dofs of each field) from the present unknowns."""
        ...


class CarriedTogether:
    """The carried fields of several terms as one; False if there are none.

    Args:
        parts: one for each term that has such fields.
    """

    def __init__(self, parts: Sequence[Carried]) -> None:
        self._parts = parts

    def __bool__(self) -> bool:
        return bool(self._parts)

    @property
    def values(self) -> np.ndarray:
        """All of them as one array, a copy."""
        return np.concatenate([np.empty(0), *(part.values for part in self._parts)])

    @values.setter
    def values(self, values: np.ndarray) -> None:
        place = 0
        for part in self._parts:
            size = len(part.values)
            part.values = values[place : place + size]
            place += size

    def reset(self) -> None:
        """Set the fields to the values that follow from the present unknowns."""
        for part in self._parts:
            part.reset()

    def follow(self, *steps: np.ndarray) -> None:
        """Predict them for ``steps`` (local dofs of each field) from the present unknowns."""
        for part in self._parts:
            part.follow(*steps)


class Regularised(ABC):
    """A term that adds a stiffness to its tangent which vanishes with the residual."""

    @abstractmethod
    def set_residual(self, residual_N: float) -> None:
        """Set the residual at which a tangent is assembled; 0 for the exact tangent."""


class CarriedStress:
    """Second Piola–Kirchhoff stress (MPa) that follows Newton's steps linearly.

    After a step w from u the stress becomes S(E(u)) + C(E(u)) : sym(Fᵀ∇w), where plain Newton
    takes S(E(u + w)). Only the geometric part of the tangent uses it, so a converged solution
    does not depend on it; large rotations no longer spoil the stress between iterations
    (Magisano, Leonetti & Garcea 2017; Pfefferkorn, Bieber, Oesterle, Bischoff & Betsch, 2021).

    Attributes:
        stress: (3, 3) at each integration point of the volume.
        on_sheets: stress at the points of each further rule, in the order of ``sheets``.

    Args:
        fields: fields that the stress depends on: displacement, and a mixed model's pressure.
        stresses: S in UFL, and the cells where it is such (all where None), part by part.
        degree: degree of the integration rule.
        sheets: what has a rule of its own, or another degree: stress of sheets (N/mm), or a further
            one of the solid (MPa); its cells, and the rule.
    """

    def __init__(
        self,
        fields: Sequence[fem.Function],
        stresses: Sequence[tuple[Expr, np.ndarray | None]],
        degree: int,
        sheets: Sequence[tuple[Expr, np.ndarray, Rule | int]] = (),
    ) -> None:
        mesh = fields[0].function_space.mesh
        self.stress = points.field(mesh, (3, 3), degree, "carried_stress_MPa")
        self._steps = [fem.Function(field.function_space) for field in fields]
        self._fields = fields
        self._now: list[tuple[AtPoints, fem.Function]] = []
        self._after: list[tuple[AtPoints, fem.Function]] = []
        for stress, cells in stresses:
            self._add(stress, degree, cells, self.stress)
        self.on_sheets = []
        for stress, on, rule in sheets:
            carried = points.field(mesh, (3, 3), rule, "carried_stress_N_per_mm")
            self._add(stress, rule, on, carried)
            self.on_sheets.append(carried)

    def _add(
        self, stress: Expr, rule: int | Rule, cells: np.ndarray | None, into: fem.Function
    ) -> None:
        mesh = into.function_space.mesh
        predicted = stress
        for field, step in zip(self._fields, self._steps, strict=True):
            predicted = predicted + chain_rule.along(stress, field, step)
        self._now.append((AtPoints(stress, mesh, rule, cells), into))
        self._after.append((AtPoints(predicted, mesh, rule, cells), into))

    @property
    def values(self) -> np.ndarray:
        """All carried stresses as one array, a copy."""
        return np.concatenate([held.x.array for held in (self.stress, *self.on_sheets)])

    @values.setter
    def values(self, values: np.ndarray) -> None:
        place = 0
        for held in (self.stress, *self.on_sheets):
            held.x.array[:] = values[place : place + held.x.array.size]
            place += held.x.array.size

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

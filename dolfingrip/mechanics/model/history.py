"""Internal variables, and the constants that tell a potential the time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.mechanics.model import points
from dolfingrip.mechanics.model.points import AtPoints
from dolfingrip.mechanics.model.state import Memory


class History(Memory):
    """Internal variables at the integration points: a memory of a model.

    During a load step they have the values at its start, and the potential is that of the
    increment. When the step is accepted they take the values at its end.

    Args:
        u: displacement (mm).
        degree: of the rule that the strain energies are integrated with.

    Attributes:
        time_s: constant with the time at the load step's end.
        step_s: constant with the length of the load step; 0 if no time passes.
    """

    def __init__(self, u: fem.Function, degree: int) -> None:
        self._u = u
        self._degree = degree
        mesh = u.function_space.mesh
        self.time_s = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self.step_s = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self._variables: dict[str, fem.Function] = {}
        self._updates: list[tuple[fem.Function, AtPoints]] = []

    def variable(self, name: str, initial: np.ndarray | float) -> fem.Function:
        """A new internal variable of the shape of ``initial``, which is its first value."""
        assert name not in self._variables
        value = np.asarray(initial, dtype=float)
        made = points.field(self._u.function_space.mesh, value.shape, self._degree, name)
        made.x.array[:] = np.tile(value.ravel(), made.x.array.size // value.size)
        self._variables[name] = made
        return made

    def evolve(self, variable: fem.Function, end: Expr) -> None:
        """Let an accepted step set ``variable`` to the value of ``end`` at the present u."""
        mesh = self._u.function_space.mesh
        self._updates.append((variable, AtPoints(end, mesh, self._degree)))

    # -- as a memory -----------------------------------------------------------------------------

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the constants."""
        self.time_s.value, self.step_s.value = time_s, step_s

    def accept(self) -> None:
        """Update all variables at once from the values at the step's start."""
        found = [(variable, end.values().ravel()) for variable, end in self._updates]
        for variable, values in found:
            variable.x.array[: values.size] = values

    def values(self) -> dict[str, np.ndarray]:
        """Internal variables by name; the displacement is the state's own."""
        return {name: made.x.array.copy() for name, made in self._variables.items()}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Set the variables."""
        for name, made in self._variables.items():
            made.x.array[:] = values[name]

"""The state of a model between load steps, and internal variables, which remember a part of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.mechanics.model import points
from dolfingrip.mechanics.model.points import AtPoints


@dataclass(frozen=True, slots=True)
class Guess:
    """An estimate from which Newton's method starts.

    Attributes:
        unknowns: local array of the model's unknowns.
        carried: values of the fields that its tangent carries along.
    """

    unknowns: np.ndarray
    carried: np.ndarray


@dataclass(slots=True)
class State:
    """A point on a load path that can be restored and stored.

    Attributes:
        displacement: this rank's displacement dofs, ghosts included (mm).
        controls: prescribed quantities by name, in the unit of the name (``pressure_kPa``,
            ``time_s``).
        pressure: this rank's dofs of a mixed model's pressure field, ghosts included (MPa).
        global_unknowns: global unknowns by name with unit.
        history: internal variables by name, this rank's values.
    """

    displacement: np.ndarray
    controls: dict[str, float]
    pressure: np.ndarray | None = None
    global_unknowns: dict[str, float] = field(default_factory=dict)
    history: dict[str, np.ndarray] = field(default_factory=dict)


class Memory:
    """Something with a memory: a term, internal variables, a line that supplies pressure.

    A memory overrides the methods that it needs; the inherited ones do nothing.
    """

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the time at the load step's end and the step's length (s)."""

    def set_cycle(self, cycle: float) -> None:
        """Set the number of the cycle at the load step's end, from 1 on."""

    def step_error(self) -> float:
        """Error of a converged load step by the allowed one, the same on all ranks; 0 if none."""
        return 0.0

    def accept(self) -> None:
        """Store the values at the end of a load step that has converged."""

    def values(self) -> dict[str, np.ndarray]:
        """Copies of the stored values, by name."""
        return {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore values that :meth:`values` returned."""


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
        cycle: constant with the number of the cycle at the load step's end.
    """

    def __init__(self, u: fem.Function, degree: int) -> None:
        self._u = u
        self._degree = degree
        mesh = u.function_space.mesh
        self.time_s = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self.step_s = fem.Constant(mesh, PETSc.ScalarType(0.0))
        self.cycle = fem.Constant(mesh, PETSc.ScalarType(1.0))
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

    def set_cycle(self, cycle: float) -> None:
        """Set the constant."""
        self.cycle.value = cycle

    def accept(self) -> None:
        """Update all variables at once from the values at the step's start."""
        new_values = [(variable, end.values().ravel()) for variable, end in self._updates]
        for variable, values in new_values:
            variable.x.array[: values.size] = values

    def values(self) -> dict[str, np.ndarray]:
        """Internal variables by name; the displacement is the state's own."""
        return {name: made.x.array.copy() for name, made in self._variables.items()}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Set the variables."""
        for name, made in self._variables.items():
            made.x.array[:] = values[name]

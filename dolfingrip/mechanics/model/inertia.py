"""Inertia of a solid: its incremental potential, and the motion that it remembers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, reduce
from operator import add
from typing import Final

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.forms import inertia
from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.state import Memory

T_MM3: Final = 1e-12
"""t/mm³ per kg/m³."""


class Inertia(Memory):
    """The velocity and acceleration of a solid; see :mod:`dolfingrip.forms.inertia`.

    Where no time passes, as on the way to rest, it does nothing.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        densities_kg_m3: by the names of parts, none for the whole.
        alpha: α of the scheme.
        error_mm: error of a step that is allowed.
        from_s: time up to which it does nothing, as long as the solid moves quasi-statically.

    Attributes:
        velocity, acceleration: this rank's dofs at the step's start, ghosts included (mm/s, mm/s²).
        energy: the incremental potential (mJ of the meshed part) as a form.
    """

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        densities_kg_m3: Mapping[tuple[str, ...], float],
        alpha: float = 0.0,
        error_mm: float = np.inf,
        from_s: float = 0.0,
    ) -> None:
        self._u, self._error_mm, self._from_s = u, error_mm, from_s
        self._scheme = inertia.scheme(alpha)
        mesh, space = domain.mesh, u.function_space
        self._predicted, self._forces = fem.Function(space), fem.Function(space)
        self._before = u.x.array.copy()
        self.velocity, self.acceleration = np.zeros_like(u.x.array), np.zeros_like(u.x.array)
        self._still = np.zeros_like(u.x.array)
        self._step_s = 0.0
        self._rate, *numbers = (fem.Constant(mesh, PETSc.ScalarType(x)) for x in (0.0, alpha))
        parts = [
            (
                fem.Constant(mesh, PETSc.ScalarType(T_MM3 * density)),
                domain.volume(*names, quadrature_degree=2 * space.ufl_element().degree),
            )
            for names, density in densities_kg_m3.items()
        ]
        v, w = ufl.TestFunction(space), ufl.TrialFunction(space)
        self._mass = reduce(add, (density * ufl.inner(v, w) * dx for density, dx in parts))
        motion = (u, self._predicted, self._forces)
        self.energy: ufl.Form = reduce(
            add,
            (inertia.energy(*motion, density, self._rate, *numbers) * dx for density, dx in parts),
        )

    @cached_property
    def mass(self) -> PETSc.Mat:
        """The consistent mass matrix (t) of the meshed part, without regard to supports."""
        from dolfinx.fem import petsc

        found = petsc.assemble_matrix(to_assemble(self._mass))
        found.assemble()
        return found

    def kinetic_mJ(self, velocity: np.ndarray | None = None) -> float:
        """Kinetic energy of the meshed part at the step's start, or of a velocity (local array)."""
        x, y = self.mass.createVecs()
        x.array[:] = (self.velocity if velocity is None else velocity)[: x.local_size]
        self.mass.mult(x, y)
        return float(x.dot(y)) / 2

    # -- as a memory -----------------------------------------------------------------------------

    def set_time(self, time_s: float, step_s: float) -> None:
        """Predict the step's end."""
        _, beta, _ = self._scheme
        self._step_s = step_s = step_s if time_s > self._from_s else 0.0
        moved = step_s * self.velocity + (0.5 - beta) * step_s**2 * self.acceleration
        self._predicted.x.array[:] = self._before + moved
        self._rate.value = 1 / (beta * step_s**2) if step_s > 0 else 0.0
        self._forces.x.array[:] = self._still if step_s > 0 else 0.0

    def _end(self) -> np.ndarray:
        """Acceleration at the step's end (mm/s²)."""
        return np.asarray(float(self._rate.value) * (self._u.x.array - self._predicted.x.array))

    def end_velocity(self) -> np.ndarray:
        """Velocity at the step's end, before it is accepted (local array, mm/s)."""
        _, _, gamma = self._scheme
        change = (1 - gamma) * self.acceleration + gamma * self._end()
        return np.asarray(self.velocity + self._step_s * change)

    def step_error(self) -> float:
        """Error of the converged step by the allowed one.

        Of the displacement at a step's end the scheme lacks (β − 1/6) Δt² (a − a₀) (Zienkiewicz &
        Xie, Earthquake Eng. Struct. Dyn. 20, 1991).
        """
        if not self._step_s:
            return 0.0
        change = self._end() - self.acceleration
        lacking = (self._scheme.beta - 1 / 6) * self._step_s**2 * np.abs(change).max(initial=0.0)
        comm = self._u.function_space.mesh.comm
        return float(comm.allreduce(lacking, MPI.MAX)) / self._error_mm

    def accept(self) -> None:
        """Take the motion at the step's end."""
        if self._step_s:
            alpha, end = self._scheme.alpha, self._end()
            self.velocity = self.end_velocity()
            self._still = (alpha * self._still - end) / (1 + alpha)
            self.acceleration = end
        self._before = self._u.x.array.copy()

    def start(self, velocity: np.ndarray, acceleration: np.ndarray) -> None:
        """Begin with a motion (local arrays, mm/s and mm/s²) that is in balance."""
        self.velocity[:], self.acceleration[:] = velocity, acceleration
        self._still = -self.acceleration

    def values(self) -> dict[str, np.ndarray]:
        """The motion, by name."""
        stored = (self._before, self.velocity, self.acceleration, self._still)
        return {name: each.copy() for name, each in zip(_NAMES, stored, strict=True)}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Set the motion."""
        self._before, self.velocity, self.acceleration, self._still = (
            values[name].copy() for name in _NAMES
        )


_NAMES: Final = tuple(
    f"inertia.{each}" for each in ("before_mm", "velocity", "acceleration", "forces_by_mass")
)

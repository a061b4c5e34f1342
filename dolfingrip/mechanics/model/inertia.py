"""Inertia of a solid: its incremental potential, and the motion that it remembers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add
from typing import Final

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.forms import inertia
from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.state import Memory
from dolfingrip.mechanics.model.time_integrator import TimeIntegrator

T_MM3: Final = 1e-12
"""t/mm³ per kg/m³."""


@dataclass(frozen=True, slots=True)
class FaceMass:
    """A mass that is fixed to a face and turns with it.

    Attributes:
        density_t_mm2: mass by the face's undeformed area.
        lever_mm: distance of its centre from the face, outwards.
        area: measure of the face.
    """

    density_t_mm2: Expr
    lever_mm: Expr
    area: ufl.Measure

    def moved(self, u: Expr) -> Expr:
        """Displacement of the mass by that of the solid, which it is linear in (mm)."""
        return u + self.lever_mm * ufl.dot(ufl.grad(u), ufl.FacetNormal(self.area.ufl_domain()))


class Inertia(Memory):
    """The velocity and acceleration of a solid; see :mod:`dolfingrip.forms.inertia`.

    Where no time passes, as on the way to rest, it does nothing.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        densities_t_mm3: by the names of parts, none for the whole.
        masses: fixed to its faces.
        alpha: α of the scheme.
        error_mm: error of a step that is allowed.
        from_s: time up to which it does nothing, as long as the solid moves quasi-statically.
        base_mm_s: returns the velocity of what places are seen from, (3,), by the time (s); None:
            it stands still.

    Attributes:
        motion: of this rank's dofs, ghosts included.
        energy: the incremental potential (mJ of the meshed part) as a form.
    """

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        densities_t_mm3: Mapping[tuple[str, ...], fem.Constant],
        masses: Sequence[FaceMass] = (),
        alpha: float = 0.0,
        error_mm: float = np.inf,
        from_s: float = 0.0,
        base_mm_s: Callable[[float], np.ndarray] | None = None,
    ) -> None:
        self._u, self._error_mm, self._from_s = u, error_mm, from_s
        mesh, space = domain.mesh, u.function_space
        self.motion = TimeIntegrator("inertia", u.x.array, inertia.scheme(alpha))
        self._ahead = fem.Function(space)
        self._base_mm_s = base_mm_s
        self._stiffness = fem.Constant(mesh, PETSc.ScalarType(0.0))
        parts = [
            (density, domain.volume(*names, quadrature_degree=2 * space.ufl_element().degree))
            for names, density in densities_t_mm3.items()
        ]
        v, w = ufl.TestFunction(space), ufl.TrialFunction(space)
        fixed = [(mass, mass.moved(v), mass.moved(w)) for mass in masses]
        self._mass = reduce(
            add,
            [
                *(density * ufl.inner(v, w) * dx for density, dx in parts),
                *(mass.density_t_mm2 * ufl.inner(a, b) * mass.area for mass, a, b in fixed),
            ],
        )
        ahead, stiffness = self._ahead, self._stiffness
        self.energy: ufl.Form = reduce(
            add,
            [
                *(inertia.energy(u, ahead, density, stiffness) * dx for density, dx in parts),
                *(
                    inertia.energy(mass.moved(u), mass.moved(ahead), mass.density_t_mm2, stiffness)
                    * mass.area
                    for mass in masses
                ),
            ],
        )

    @cached_property
    def mass(self) -> PETSc.Mat:
        """The consistent mass matrix (t) of the meshed part, without regard to supports."""
        return self.assembled_mass()

    def assembled_mass(self) -> PETSc.Mat:
        """Assemble the mass matrix with the present densities and reference configuration."""
        from dolfinx.fem import petsc

        matrix = petsc.assemble_matrix(to_assemble(self._mass))
        matrix.assemble()
        return matrix

    def kinetic_mJ(self) -> float:
        """Kinetic energy of the meshed part at the step's end."""
        x, y = self.mass.createVecs()
        x.array[:] = self.motion.end_velocity(self._u.x.array)[: x.local_size]
        self.mass.mult(x, y)
        return float(x.dot(y)) / 2

    # -- as a memory -----------------------------------------------------------------------------

    def set_time(self, time_s: float, step_s: float) -> None:
        """Predict the step's end."""
        step_s = step_s if time_s > self._from_s else 0.0
        self.motion.set_step(step_s, self._falls(time_s, step_s))
        self._ahead.x.array[:] = self.motion.ahead
        self._stiffness.value = self.motion.stiffness

    def _falls(self, time_s: float, step_s: float) -> np.ndarray | float:
        """Mean acceleration (mm/s²) in a step of what no force holds, seen from the base."""
        if self._base_mm_s is None or not step_s:
            return 0.0
        gained = self._base_mm_s(time_s) - self._base_mm_s(time_s - step_s)
        everywhere = fem.Function(self._u.function_space)
        everywhere.interpolate(lambda x: np.outer(-gained / step_s, np.ones(x.shape[1])))
        return np.asarray(everywhere.x.array)

    def step_error(self) -> float:
        """Error of the converged step by the allowed one."""
        comm = self._u.function_space.mesh.comm
        return (
            float(comm.allreduce(self.motion.error_mm(self._u.x.array), MPI.MAX)) / self._error_mm
        )

    def accept(self) -> None:
        """Take the motion at the step's end."""
        self.motion.accept(self._u.x.array)

    def values(self) -> dict[str, np.ndarray]:
        """The motion, by name."""
        return self.motion.values()

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Set the motion."""
        self.motion.restore(values)

"""The force-sensor plate: a rigid plane that faces part of the skin."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.forms import plate as form
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import Number


class RigidPlate(Term):
    """Plane n · x = offset on whose side n points the skin stays.

    The plane lies one barrier width behind the position that first feels the skin, so that a
    gap of 0 is a touch without force.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        region: name of the part of ``domain``'s boundary that may touch.
        normal: (3,) towards the finger; any length.
        gap_mm: distance that the nearest point of ``region`` travels along −n before it
            is felt.
        width_mm: barrier width ĝ.
        stiffness_MPa: barrier stiffness κ.

    Attributes:
        energy: the UFL form of its potential.
        measure: of the part of the skin that may touch it.
        reaction: that of the normal force on the meshed part, dΠ/d(offset).
        offset: the plane's position along n (mm), a constant of the form.
        number: the plane's position as an unknown, where it is one.
    """

    name: ClassVar[str] = "plate"

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        region: str,
        normal: np.ndarray,
        *,
        gap_mm: float,
        width_mm: float,
        stiffness_MPa: float,
    ) -> None:
        self.number: Number | None = None
        self._u = u
        self._copies = domain.copies
        space, mesh = u.function_space, domain.mesh
        facets = domain.facets(region)
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        nodes = fem.locate_dofs_topological(space, 2, facets)
        self._nodes = nodes[nodes < space.dofmap.index_map.size_local]
        self._coordinates = space.tabulate_dof_coordinates()[self._nodes].copy()
        self._now = self._coordinates
        self._rest = self._now @ self.normal
        nearest = mesh.comm.allreduce(self._rest.min(initial=np.inf), MPI.MIN)
        self.width_mm = width_mm
        self.offset = fem.Constant(mesh, PETSc.ScalarType(nearest - gap_mm - width_mm))

        n = fem.Constant(mesh, self.normal)
        facet = mesh.ufl_cell().facet_types()[0].cellname()
        ds = domain.surface(region, **form.nodal_rule(facet, space.ufl_element().degree))
        width = fem.Constant(mesh, PETSc.ScalarType(width_mm))
        stiffness = fem.Constant(mesh, PETSc.ScalarType(stiffness_MPa))
        self._facing = n

        def density(u: Expr, offset: Expr) -> Expr:
            return form.energy(form.distance(u, mesh, n, offset), width, stiffness)

        self._density = density
        self.measure = ds
        self.energy = density(u, self.offset) * ds
        self.reaction = self.pressure(u, self.offset) * ds
        self._reaction = fem.form(self.reaction, jit_options=jit.options())

    def pressure(self, u: Expr, offset: Expr) -> Expr:
        """Contact pressure (MPa) on the skin displaced by ``u`` from a plane at ``offset``."""
        position = ufl.variable(offset)
        return ufl.diff(self._density(u, position), position)

    def along(self, vector: Expr) -> Expr:
        """The part of ``vector`` that is tangential to the plane."""
        return vector - ufl.inner(vector, self._facing) * self._facing

    def force_N(self) -> float:
        """Normal force on the whole finger's plate."""
        local = fem.assemble_scalar(self._reaction)
        return float(self._copies * self._u.function_space.mesh.comm.allreduce(local))

    def gap_mm(self) -> float:
        """Smallest distance of the skin's nodes from the plane."""
        gaps = self._distance(self._u.x.array)
        smallest = gaps.min(initial=np.inf)
        return float(self._u.function_space.mesh.comm.allreduce(smallest, MPI.MIN))

    def offset_rate(self, velocity: fem.Function) -> float:
        """How fast the plane follows the nearest point as the reference points move (mm)."""
        moving = fem.Function(self._u.function_space)
        moving.interpolate(velocity)
        rates = moving.x.array.reshape(-1, 3)[self._nodes] @ self.normal
        first = int(self._rest.argmin()) if len(self._rest) else None
        own = (np.inf, 0.0) if first is None else (self._rest[first], rates[first])
        return float(min(self._u.function_space.mesh.comm.allgather(own))[1])

    def move_reference(self, change: np.ndarray | None) -> None:
        """Take the facing nodes to be moved by ``change`` (local array, mm); None: put back."""
        self._now = self._coordinates
        if change is not None:
            self._now = self._now + change.reshape(-1, 3)[self._nodes]
        self._rest = self._now @ self.normal

    def place(self, normal: np.ndarray, gap_mm: float) -> None:
        """Set the plane at a distance from the undeformed skin, as it was made."""
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        self._facing.value[:] = self.normal
        self._rest = self._now @ self.normal
        comm = self._u.function_space.mesh.comm
        nearest = comm.allreduce(self._rest.min(initial=np.inf), MPI.MIN)
        self.offset.value = nearest - gap_mm - self.width_mm

    def _distance(self, dofs: np.ndarray) -> np.ndarray:
        moved = dofs.reshape(-1, 3)[self._nodes] @ self.normal
        return self._rest + moved - float(self.offset.value)

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction of ``step`` that leaves each node a tenth of its distance."""
        now = self._distance(dofs)
        moved = step[: len(dofs)].reshape(-1, 3)[self._nodes] @ self.normal
        approach = (0.0 if self.number is None else self.number.change(step)) - moved
        closing = approach > 0
        allowed = (0.9 * now[closing] / approach[closing]).min(initial=1.0)
        return float(self._u.function_space.mesh.comm.allreduce(allowed, MPI.MIN))

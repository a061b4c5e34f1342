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
from dolfingrip.mechanics.contact.density import TwoStage
from dolfingrip.mechanics.contact.distance import Plane
from dolfingrip.mechanics.contact.load import Load
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.pose import SIX, Pose
from dolfingrip.mechanics.model.unknowns import Number


class RigidPlate(RigidContact):
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
        measure: of the part of the skin that may touch it.
        offset: the plane's position along n (mm), its pose's only coordinate.
        reaction: the normal force on the meshed part, dΠ/d(offset), with its derivatives.
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
        mesh = domain.mesh
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        self.offset = fem.Constant(mesh, PETSc.ScalarType(0.0))
        along = np.concatenate([self.normal, np.zeros(3)])
        pose = Pose([self.offset], along[:, None], np.zeros(SIX))
        density = TwoStage(width_mm, stiffness_MPa)
        super().__init__(u, domain, [region], Plane(tuple(self.normal)), pose, density)
        self._u = u
        self._rest = self.points.rest @ self.normal
        nearest = mesh.comm.allreduce(self._rest.min(initial=np.inf), MPI.MIN)
        nearest = nearest if np.isfinite(nearest) else 0.0  # nothing faces it
        self.offset.value = nearest - gap_mm - width_mm
        self.width_mm = width_mm
        self.measure = self.points.measure
        self.reaction = Load(self, along)
        self._facing = fem.Constant(mesh, self.normal)
        self._barrier = [
            fem.Constant(mesh, PETSc.ScalarType(value)) for value in (width_mm, stiffness_MPa)
        ]

    @property
    def number(self) -> Number | None:
        """The plane's position as an unknown, where it is one."""
        return self.pose.numbers[0]

    @number.setter
    def number(self, number: Number | None) -> None:
        self.pose.numbers[0] = number

    # -- in UFL ----------------------------------------------------------------------------------

    def pressure(self, u: Expr, offset: Expr) -> Expr:
        """Contact pressure (MPa) on the skin displaced by ``u`` from a plane at ``offset``."""
        position = ufl.variable(offset)
        gap = form.distance(u, self._u.function_space.mesh, self._facing, position)
        return ufl.diff(form.energy(gap, *self._barrier), position)

    def along(self, vector: Expr) -> Expr:
        """The part of ``vector`` that is tangential to the plane."""
        return vector - ufl.inner(vector, self._facing) * self._facing

    # -- readings --------------------------------------------------------------------------------

    def force_N(self) -> float:
        """Normal force on the whole finger's plate."""
        return -float(self.load_N(self._u.x.array)[:3] @ self.normal)

    def gap_mm(self) -> float:
        """Smallest distance of the skin's nodes from the plane."""
        smallest = self.gaps_mm(self._u.x.array).min(initial=np.inf)
        return float(self._u.function_space.mesh.comm.allreduce(smallest, MPI.MIN))

    def offset_rate(self, velocity: fem.Function) -> float:
        """How fast the plane follows the nearest point as the reference points move (mm)."""
        moving = fem.Function(self._u.function_space)
        moving.interpolate(velocity)
        rates = moving.x.array.reshape(-1, 3)[self.points.nodes] @ self.normal
        first = int(self._rest.argmin()) if len(self._rest) else None
        own = (np.inf, 0.0) if first is None else (self._rest[first], rates[first])
        return float(min(self._u.function_space.mesh.comm.allgather(own))[1])

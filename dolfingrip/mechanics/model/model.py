"""A mechanical model: displacement, total potential, supports, contact, controls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from dolfinx import fem, la
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.model.unknowns import Unknowns

INVERTED = "inverted"
"""Name of what bounds a step that would turn an element inside out."""

SHORTEST = 1e-6
"""Fraction of a step below which none is looked for."""


class StepBound(Protocol):
    """What limits the length of a Newton step."""

    name: str

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest allowed fraction of ``step`` (local dofs, mm) in [0, 1], on all ranks."""
        ...


class Prescribed(Protocol):
    """A quantity that a load path may lead."""

    @property
    def value(self) -> float:
        """Present value, in the unit that its name says."""
        ...

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        ...


class Memory(Protocol):
    """What a model remembers from its last accepted state besides the displacement."""

    def follow(self, time_s: float, step_s: float) -> None:
        """Take note of the time at the load step's end and of the step's length (s)."""
        ...

    def accept(self) -> None:
        """The load step has converged: what is remembered becomes that of its end."""
        ...

    def values(self) -> dict[str, np.ndarray]:
        """What is remembered, by name; copies."""
        ...

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Remember what :meth:`values` gave."""
        ...


@dataclass(frozen=True, slots=True)
class Control:
    """A prescribed quantity: a constant of the potential and its unit's factor."""

    constant: fem.Constant
    factor: float = 1.0

    @property
    def value(self) -> float:
        """Present value, in the unit that the control's name says."""
        return float(self.constant.value) / self.factor

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        self.constant.value = value * self.factor


@dataclass(slots=True)
class Model:
    """What is solved for a stationary point of Π, and its state.

    Attributes:
        domain: reference configuration.
        u: displacement (mm).
        potential: all energies written in UFL.
        supports: homogeneous displacement conditions.
        controls: prescribed quantities by name with unit.
        contact: barrier contact, where there is any.
        bounds: limits of a Newton step besides contact.
        memories: what the state has besides the displacement: internal variables, for one.
        time_s: time at the load step's end.
        p: pressure field of a mixed model (MPa).
        unknowns: u, and p where there is one, as one vector.
    """

    domain: Domain
    u: fem.Function
    potential: Potential
    supports: list[fem.DirichletBC]
    controls: dict[str, Prescribed]
    contact: BarrierContact | None = None
    bounds: Sequence[StepBound] = ()
    memories: Sequence[Memory] = ()
    time_s: float = 0.0
    p: fem.Function | None = None
    unknowns: Unknowns = field(init=False, repr=False)
    _clock: str = field(default="time_s", init=False)
    _accepted_s: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self.unknowns = Unknowns([self.u] if self.p is None else [self.u, self.p])

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the model's mesh."""
        return self.domain.mesh.comm

    @property
    def dofs(self) -> int:
        """Number of unknowns on all ranks."""
        return int(self.unknowns.count)

    # -- state ---------------------------------------------------------------------------------

    def state(self) -> State:
        """A copy of the present state."""
        controls = {name: control.value for name, control in self.controls.items()}
        pressure = None if self.p is None else self.p.x.array.copy()
        history = {k: v for memory in self.memories for k, v in memory.values().items()}
        controls[self._clock] = self.time_s
        return State(self.u.x.array.copy(), controls, pressure, history)

    def restore(self, state: State) -> None:
        """Go back (or over) to ``state``, one that was accepted."""
        self.u.x.array[:] = state.displacement
        if self.p is not None:
            self.p.x.array[:] = state.pressure
        self._accepted_s = state.controls.get(self._clock, self.time_s)
        for memory in self.memories:
            memory.restore(state.history)
        self.prescribe(state.controls)

    def prescribe(self, controls: Mapping[str, float]) -> None:
        """Set controls by name; time is one of them."""
        for name, value in controls.items():
            if name == self._clock:
                self.time_s = value
            else:
                self.controls[name].set(value)
        step_s = max(self.time_s - self._accepted_s, 0.0)
        for memory in self.memories:
            memory.follow(self.time_s, step_s)

    def accept_step(self) -> None:
        """Take the present, converged state as the start of the next load step."""
        for memory in self.memories:
            memory.accept()
        self._accepted_s = self.time_s
        self.prescribe({})

    # -- Newton's operands ---------------------------------------------------------------------

    def assemble_residual(self, residual: PETSc.Vec, *, supported: bool = True) -> None:
        """Gradient of Π with respect to u at the present state (N) into ``residual``.

        Args:
            residual: overwritten.
            supported: put 0 in the rows of supported dofs; their reactions otherwise.
        """
        with residual.localForm() as local:
            local.set(0.0)
        fem_petsc.assemble_vector(residual, self.potential.residual)
        residual.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        if self.contact is not None:
            self.contact.add_gradient(self.u.x.array, residual)
            residual.assemble()
        if supported:
            self.release(residual)

    def assemble_equations(self, residual: PETSc.Vec) -> None:
        """Gradient of Π with respect to all unknowns (N, and mm³ for p) into ``residual``."""
        if self.p is None:
            self.assemble_residual(residual)
            return
        forces = fem_petsc.create_vector(self.potential.residual)
        self.assemble_residual(forces)
        constraint = fem.assemble_vector(self.potential.constraint)
        constraint.scatter_reverse(la.InsertMode.add)
        owned = len(forces.array_r)
        residual.array[:owned] = forces.array_r
        residual.array[owned:] = constraint.array[: residual.getLocalSize() - owned]
        forces.destroy()

    def release(self, forces: PETSc.Vec) -> None:
        """Put 0 in the rows of supported dofs, whose forces the supports take."""
        for bc in self.supports:
            dofs, owned = bc.dof_indices()
            forces.array[dofs[:owned]] = 0.0

    def max_step(self, step: np.ndarray) -> tuple[float, str]:
        """Largest fraction of ``step`` that no bound forbids, and the bound that set it.

        Args:
            step: of the unknowns, as a local array.
        """
        step = self.unknowns.parts(step)[0]
        fraction, reason = 1.0, ""
        bounds: list[StepBound] = [*self.bounds]
        if self.contact is not None:
            bounds.append(self.contact)
        for bound in bounds:
            allowed = bound.max_step(self.u.x.array, step)
            if allowed < fraction:
                fraction, reason = allowed, bound.name
        return fraction, reason

    def admissible_step(self, step: np.ndarray) -> tuple[float, str]:
        """As :meth:`max_step`, shortened until no element inverts (J stays above a tenth).

        Inversion is looked at first: contact is searched along the whole way, and that of a step
        gone astray is long.
        """
        least = 0.1 * min(self._smallest_jacobian(), 1.0)
        fraction, reason = self._upright(step, 1.0, least)
        allowed, bound = self.max_step(fraction * step)
        if allowed < 1.0:
            fraction, inverted = self._upright(step, allowed * fraction, least)
            reason = inverted or bound
        return fraction, reason

    def _smallest_jacobian(self) -> float:
        """Smallest det F on all ranks."""
        return float(self.comm.allreduce(self.potential.smallest_jacobian(), MPI.MIN))

    def _upright(self, step: np.ndarray, longest: float, least: float) -> tuple[float, str]:
        """``longest``, halved until that part of ``step`` leaves J above ``least``, and why."""
        step = self.unknowns.parts(step)[0]
        start = self.u.x.array.copy()
        fraction, reason = longest, ""
        try:
            while fraction > SHORTEST:
                self.u.x.array[:] = start + fraction * step
                if self._smallest_jacobian() > least:
                    return fraction, reason
                fraction, reason = fraction / 2, INVERTED
        finally:
            self.u.x.array[:] = start
        return 0.0, INVERTED

"""A mechanical model: unknowns, the terms of its potential, supports, controls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.assembly import box
from dolfingrip.mechanics.model.carried_stress import CarriedStress
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.state import Memory, State
from dolfingrip.mechanics.model.supports import MovingSupport
from dolfingrip.mechanics.model.term import Lagged, Term
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient, Unknowns

INVERTED = "inverted"
"""Name of the bound on a step that would turn an element inside out."""


@dataclass(frozen=True, slots=True)
class StepBounds:
    """How far one step of Newton's method may go, whatever the terms allow.

    Attributes:
        kept_jacobian: part of the smallest det F that a step keeps, so that no element inverts.
        shortest: smallest fraction of a step that is tried.
    """

    kept_jacobian: float = 0.1
    shortest: float = 1e-6


class Prescribed(Protocol):
    """A quantity that a load path may prescribe."""

    @property
    def value(self) -> float:
        """Present value, in the unit of its name."""
        ...

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        ...


@dataclass(frozen=True, slots=True)
class Control:
    """A prescribed quantity: a constant of the potential, with the factor of its unit."""

    constant: fem.Constant
    factor: float = 1.0

    @property
    def value(self) -> float:
        """Present value, in the unit of the control's name."""
        return float(self.constant.value) / self.factor

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        self.constant.value = value * self.factor


@dataclass(slots=True)
class SetPoint:
    """A prescribed quantity that is no constant of the potential.

    Attributes:
        value: present value, in the unit of the control's name.
    """

    value: float = 0.0

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        self.value = value


@dataclass(slots=True)
class Model:
    """Unknowns, potential Π and state of a system; solvers seek a stationary point of Π.

    Attributes:
        domain: reference configuration.
        u: displacement (mm).
        potential: all energies written in UFL, the first term of Π.
        supports: homogeneous displacement conditions.
        controls: prescribed quantities by name with unit.
        terms: further terms of Π.
        memories: further parts of the state, such as internal variables.
        time_s: time at the load step's end.
        p: pressure field of a mixed model (MPa).
        global_unknowns: global unknowns that the potential does not contain.
        cycle_at: returns the number of the cycle, from 1 on, by the time (s).
        constraint: a support among ``supports`` that follows global unknowns.
        step_bounds: how far one step of Newton's method may go, whatever the terms allow.
        unknowns: u, p if there is one, and all global unknowns as one vector.
    """

    domain: Domain
    u: fem.Function
    potential: Potential
    supports: list[fem.DirichletBC]
    controls: dict[str, Prescribed]
    terms: Sequence[Term] = ()
    memories: Sequence[Memory] = ()
    time_s: float = 0.0
    p: fem.Function | None = None
    global_unknowns: Sequence[GlobalUnknown] = ()
    cycle_at: Callable[[float], float] = lambda time_s: 1.0
    constraint: MovingSupport | None = None
    step_bounds: StepBounds = field(default_factory=StepBounds)
    unknowns: Unknowns = field(init=False, repr=False)
    _clock: str = field(default="time_s", init=False)
    _accepted_s: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        fields = [self.u] if self.p is None else [self.u, self.p]
        self.unknowns = Unknowns(fields, [*self.potential.global_unknowns, *self.global_unknowns])

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the model's mesh."""
        return self.domain.mesh.comm

    @property
    def dofs(self) -> int:
        """Number of unknowns on all ranks."""
        return int(self.unknowns.count)

    @property
    def all_terms(self) -> Sequence[Term]:
        """The summands of Π."""
        return [self.potential, *self.terms]

    @property
    def _remembering(self) -> Sequence[Memory]:
        return [*self.memories, *(term for term in self.terms if isinstance(term, Memory))]

    def with_term(
        self,
        term: Term,
        global_unknowns: Sequence[GlobalUnknown],
        controls: Mapping[str, Prescribed],
    ) -> Model:
        """A model of these fields with one further term, the term's unknowns and its controls."""
        return self._replaced(
            terms=[*self.terms, term],
            global_unknowns=[*self.global_unknowns, *global_unknowns],
            controls={**self.controls, **controls},
        )

    def without_supplies(self) -> Model:
        """A model of these fields and terms without the controls that remember, as supplies do."""
        kept = {name: c for name, c in self.controls.items() if not isinstance(c, Memory)}
        supplies = {*map(id, self.controls.values())}
        memories = [memory for memory in self.memories if id(memory) not in supplies]
        return self._replaced(controls=kept, memories=memories)

    def _replaced(self, **parts: Any) -> Model:
        """A model of the same fields with other parts, at the same time."""
        made = replace(self, **parts)
        made._accepted_s = self._accepted_s
        return made

    # -- state ---------------------------------------------------------------------------------

    def state(self) -> State:
        """A copy of the present state."""
        controls = {name: control.value for name, control in self.controls.items()}
        pressure = None if self.p is None else self.p.x.array.copy()
        global_unknowns = {unknown.name: unknown.value for unknown in self.unknowns.global_unknowns}
        history = {k: v for memory in self._remembering for k, v in memory.values().items()}
        controls[self._clock] = self.time_s
        return State(self.u.x.array.copy(), controls, pressure, global_unknowns, history)

    def restore(self, state: State) -> None:
        """Set the model to ``state``, an accepted one."""
        self.u.x.array[:] = state.displacement
        if self.p is not None:
            self.p.x.array[:] = state.pressure
        for unknown in self.unknowns.global_unknowns:
            unknown.constant.value = state.global_unknowns[unknown.name]
        self._accepted_s = state.controls.get(self._clock, self.time_s)
        for memory in self._remembering:
            memory.restore(state.history)
        self.prescribe(state.controls)

    def prescribe(self, controls: Mapping[str, float]) -> None:
        """Set controls by name; the time is a control."""
        for name, value in controls.items():
            if name == self._clock:
                self.time_s = value
            else:
                self.controls[name].set(value)
        step_s = max(self.time_s - self._accepted_s, 0.0)
        for memory in self._remembering:
            memory.set_time(self.time_s, step_s)
            memory.set_cycle(self.cycle_at(self.time_s))

    def step_error(self) -> float:
        """Largest error of the converged load step by the allowed one."""
        return max((memory.step_error() for memory in self._remembering), default=0.0)

    def accept_step(self) -> None:
        """Take the present, converged state as the start of the next load step."""
        for memory in self._remembering:
            memory.accept()
        self._accepted_s = self.time_s
        self.prescribe({})

    # -- the potential and Newton's operands -----------------------------------------------------

    def energy(self) -> float:
        """Π of the meshed part (mJ), all terms, at the present state."""
        return sum(term.value(self.u.x.array) for term in self.all_terms)

    def gradient(self, *, supported: bool = True) -> np.ndarray:
        """Derivatives of Π by this rank's owned unknowns (N), in the order of a vector of them.

        Args:
            supported: whether the rows of supported dofs are 0; else they are the reactions.
        """
        gradient = Gradient(self.unknowns)
        for term in self.all_terms:
            term.add_gradient(self.u.x.array, gradient)
        if not supported:
            return gradient.array
        forces_N = gradient.array.copy() if self.constraint else gradient.array
        gradient.array[self.supported] = 0.0
        if self.constraint:
            self.constraint.add_gradient(self.u.x.array, forces_N, gradient)
        return gradient.array

    @property
    def supported(self) -> np.ndarray:
        """Owned dofs that supports prescribe, in a vector's order."""
        indices = (bc.dof_indices() for bc in self.supports)
        return np.concatenate([np.zeros(0, int), *(dofs[:owned] for dofs, owned in indices)])

    @property
    def nodes_mm(self) -> np.ndarray:
        """Reference places of the displacement's owned nodes, (n, 3)."""
        space = self.u.function_space
        return np.asarray(space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local])

    @property
    def box_mm(self) -> np.ndarray:
        """Least and largest coordinates of the reference nodes of all ranks, (2, 3)."""
        return box(self.comm, self.nodes_mm)

    @property
    def free(self) -> np.ndarray:
        """1 for each owned unknown in a vector's order; 0 for supported unknowns and fillers."""
        free = np.ones(self.unknowns.owned_size)
        free[self.supported] = 0.0
        self.unknowns.global_rows(free)[len(self.unknowns.global_unknowns) :] = 0.0
        return free

    @property
    def dependent_dofs(self) -> np.ndarray:
        """This rank's owned displacement dofs that follow global unknowns."""
        return np.empty(0, dtype=np.int64) if self.constraint is None else self.constraint.dofs

    def constraint_hessian(
        self, product: Callable[[np.ndarray], np.ndarray]
    ) -> sp.csr_matrix | None:
        """The constraint's part of Π's second derivatives; None if there is no constraint.

        Args:
            product: of the second derivatives of all terms, supports not regarded, and an owned
                array in the order of a vector.

        Returns:
            (owned, all) rows and columns in that order.
        """
        if self.constraint is None:
            return None
        return self.constraint.hessian(self.unknowns, self.free, product)

    def enforce_constraint(self) -> None:
        """Set the dependent displacements that follow from the global unknowns."""
        if self.constraint is not None:
            self.constraint.place()

    def move_reference(self, change: np.ndarray | None) -> None:
        """Tell all terms that the reference nodes have moved by ``change``; see :class:`.Term`."""
        if self.constraint is not None:
            self.constraint.measure()
        for term in self.terms:
            term.move_reference(change)

    def assemble_equations(self, residual: PETSc.Vec) -> None:
        """Gradient of Π with respect to all unknowns (N) into ``residual``."""
        residual.array[:] = self.gradient()

    def reactions(self) -> np.ndarray:
        """Forces (N) of the supports on this rank's displacement nodes, (n, 3)."""
        displacement = self.unknowns.owned_parts(self.gradient(supported=False))[0]
        return displacement.reshape(-1, 3)

    def scale_N(self) -> float:
        """Force that the residual's tolerance refers to, if larger than the first residual."""
        return max(term.scale_N() for term in self.all_terms)

    def rejects(self) -> str:
        """Why the present, converged state is not accepted; "" if it is accepted."""
        return next(filter(None, (term.rejects(self.u.x.array) for term in self.terms)), "")

    @property
    def lagged_terms(self) -> list[Lagged]:
        """Terms with quantities that are fixed while Π is minimised."""
        return [term for term in self.terms if isinstance(term, Lagged)]

    def update_lagged(self) -> bool:
        """Update all terms' lagged quantities at the present state; return whether any changed."""
        dofs = self.u.x.array
        changed = [term.update_lagged(dofs) for term in self.lagged_terms]  # all, not up to a first
        return any(changed)

    def lag_error(self) -> float:
        """Largest relative change of lagged quantities since their last update."""
        errors = [term.lag_error(self.u.x.array) for term in self.lagged_terms]
        return max(errors, default=0.0)

    def lagged_state(self) -> list[Any]:
        """The lagged quantities, which a state does not contain."""
        return [term.lagged_state() for term in self.lagged_terms]

    def restore_lagged(self, state: Sequence[Any]) -> None:
        """Set the lagged quantities to those that :meth:`lagged_state` returned."""
        for term, lagged in zip(self.lagged_terms, state, strict=True):
            term.restore_lagged(lagged)

    @property
    def carried(self) -> CarriedStress:
        """The stress that the tangent carries along Newton's steps."""
        return self.potential.carried

    @property
    def singular_at_rest(self) -> bool:
        """True if a term's tangent may have no stiffness against some motions at rest."""
        return any(term.singular_at_rest for term in self.all_terms)

    @property
    def crowded(self) -> set[str]:
        """Names of terms that press surfaces on one another over wide areas."""
        return {term.name for term in self.all_terms if term.crowded}

    def set_residual(self, residual_N: float) -> None:
        """Tell terms the residual at which a tangent is assembled."""
        for term in self.terms:
            term.set_residual(residual_N)

    def max_step(self, step: np.ndarray) -> tuple[float, str]:
        """Largest fraction of ``step`` that no term forbids, and the term that set it.

        Args:
            step: local array of the unknowns.
        """
        fraction, reason = 1.0, ""
        for term in self.terms:
            allowed = term.max_step(self.u.x.array, step)
            if allowed < fraction:
                fraction, reason = allowed, term.name
        return fraction, reason

    def admissible_step(self, step: np.ndarray) -> tuple[float, str]:
        """:meth:`max_step`, shortened until no element inverts (J stays above a tenth).

        Inversion is checked first, because contact is searched along the whole step, which may be
        very long.
        """
        least = self.step_bounds.kept_jacobian * min(self._smallest_jacobian(), 1.0)
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
        """``longest``, halved until J stays above ``least`` in this part of ``step``; its bound."""
        step = self.unknowns.parts(step)[0]
        start = self.u.x.array.copy()
        fraction, reason = longest, ""
        try:
            while fraction > self.step_bounds.shortest:
                self.u.x.array[:] = start + fraction * step
                if self._smallest_jacobian() > least:
                    return fraction, reason
                fraction, reason = fraction / 2, INVERTED
        finally:
            self.u.x.array[:] = start
        return 0.0, INVERTED

"""Derivatives of a model's states by its parameters along the load path: forward mode."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.state import Memory, State
from dolfingrip.mechanics.sensitivity.repeated_step import Change, Perturbation, RepeatedStep

CHANGE: Final = 1e-7
"""Part of a parameter's scale by which a model is perturbed. The residual of a solution is 0 to
Newton's tolerance, so that a one-sided difference is good to this part, and rounding to 1e-6."""

CORRECTIONS: Final = 30
"""Largest number of corrections where terms have lagged quantities, as friction has normal forces,
whose change the tangent leaves out; each is a solve with the present tangent."""

CLOSE: Final = 1e-6
"""Part of the first residual's derivative that may be left then."""

STALLED: Final = 0.9
"""Part of a correction's residual from which on the next one gains nothing."""

Readings = Mapping[str, float]


class ForwardSensitivity:
    """Derivatives of all states on a load path by several parameters.

    In an accepted step the state x satisfies R(x; x₀, h₀, m) = 0, and the internal variables
    become h = H(x; x₀, h₀, m), where x₀ and h₀ are those of the step's start. So

        K dx = −(∂R/∂m + ∂R/∂x₀ dx₀ + ∂R/∂h₀ dh₀),

    and dh follows from H's derivative (Michaleris, Tortorelli & Vidal, Int. J. Numer. Methods Eng.
    37, 1994). The bracket is one difference of R: the model starts from a state that is perturbed
    along (dx₀, dh₀) with a perturbed parameter, by the calls of any step. Every term, memory and
    control therefore takes part, and none is named here. K is the tangent of the converged state,
    factorised once for all parameters.

    Args:
        model: model at rest, at the start of its path.
        linear: returns K⁻¹ at the model's present state, for owned arrays in a vector's order.
        perturbations: a perturbation for each parameter.

    Attributes:
        changes: derivatives of the present state, one for each parameter.
    """

    def __init__(
        self,
        model: Model,
        linear: Callable[[], Callable[[np.ndarray], np.ndarray]],
        perturbations: Sequence[Perturbation],
    ) -> None:
        self._model = model
        self._linear = linear
        self._perturbations = perturbations
        self._before: State | None = None
        unknowns = model.unknowns.local()
        self._derived: np.ndarray | None = None
        # With friction's pairs as an update at the solution finds them. Newton's method may hold
        # those of an earlier iterate, without a pair that has just come within the barrier.
        self._history: Mapping[str, np.ndarray] | None = None
        self.changes = [Change(np.zeros_like(unknowns)) for _ in perturbations]

    # -- along the path --------------------------------------------------------------------------

    def converged(self, before: State) -> None:
        """Store a converged load step from ``before`` that is not accepted yet.

        Without history only the last step matters, so it is derived only when it is asked for.
        """
        self._before = before
        if before.history:
            self._advance(before)

    def begun(self, memory: Memory, begin: Callable[[], None]) -> None:
        """Derive the values that a memory begins with at the present, accepted state.

        Args:
            memory: of the model.
            begin: sets its values by the model's state and parameters.
        """
        model = self._model
        state, here = model.state(), model.unknowns.local()
        begin()
        base = memory.values()
        for perturbation, change, amount in self._each():
            with perturbation.applied(amount):
                model.unknowns.set_local(here + amount * change.unknowns)
                begin()
                there = memory.values()
            change.history |= {name: _rate(there[name], base[name], amount) for name in base}
        model.restore(state)
        begin()
        self._history = None

    def readings(self, read: Callable[[], Readings]) -> list[dict[str, float]]:
        """Derivatives of readings at the present, accepted state, for each parameter.

        Args:
            read: returns the model's present readings, all of them differentiable.

        Returns:
            For each parameter the derivative of each reading, for each unit of the parameter.
        """
        state = self._model.state()
        here = self._model.unknowns.local()
        if not state.history and not self._is_derived(here):
            self._advance(self._before or state)
        base = read()
        derivatives = []
        lagged = self._model.lagged_state()
        step = RepeatedStep(self._model, state, state, here, self._history)
        for perturbation, change, amount in self._each():
            with perturbation.applied(amount):
                step.begin(change, amount)
                there = read()
            derivatives.append({name: (there[name] - base[name]) / amount for name in base})
        self._model.restore(state)
        self._model.restore_lagged(lagged)
        return derivatives

    def _is_derived(self, here: np.ndarray) -> bool:
        """Return whether the present derivatives belong to the unknowns ``here``, on all ranks."""
        same = self._derived is not None and np.array_equal(self._derived, here)
        return bool(self._model.comm.allreduce(same, MPI.LAND))

    # -- one step --------------------------------------------------------------------------------

    def _advance(self, before: State) -> None:
        """Derive the present, converged state from the derivatives at ``before``."""
        model = self._model
        now, here = model.state(), model.unknowns.local()
        lagged = model.lagged_state()
        step = RepeatedStep(model, before, now, here, self._history)
        self._derived = here
        solve = self._linear()
        start = step.at_end(model.gradient)
        derivatives = np.zeros((len(start), len(self._perturbations)), order="F")
        perturbed = list(self._each())
        first, last = np.zeros(len(perturbed)), np.full(len(perturbed), np.inf)
        exact = not lagged
        due = np.arange(len(perturbed))
        for correction in range(1 if exact else CORRECTIONS):
            right: np.ndarray = np.empty((len(start), len(due)), order="F")
            for column, i in enumerate(due.tolist()):
                along = model.unknowns.to_local(derivatives[:, i])
                moved = step.at_end(model.gradient, *perturbed[i], along)
                right[:, column] = (moved - start) / perturbed[i][2]
                if not correction:
                    derivatives[:, i] = step.placed(perturbed[i][2])
            size = np.sqrt(model.comm.allreduce(np.sum(right**2, axis=0), MPI.SUM))
            if not correction:
                first = np.maximum(size, np.finfo(float).tiny)
            # what falls no more is rounding
            falls = size < STALLED * last[due]
            remaining = falls & (size > CLOSE * first[due])
            due, right = due[remaining], right[:, remaining]
            last[due] = size[remaining]
            if not len(due):
                break
            derivatives[:, due] -= solve(np.asfortranarray(right))
        after = step.at_end(self._evolved) if before.history else {}
        for i, (perturbation, change, amount) in enumerate(perturbed):
            unknowns = model.unknowns.to_local(derivatives[:, i])
            if before.history:
                there = step.at_end(self._evolved, perturbation, change, amount, unknowns)
                change.history = {k: _rate(there[k], after[k], amount) for k in after}
            change.unknowns = unknowns
        self._history = after or None
        model.restore(before)
        model.prescribe(step.controlled(now))
        model.unknowns.set_local(here)
        model.restore_lagged(lagged)

    def _evolved(self) -> Mapping[str, np.ndarray]:
        """Internal variables once the present state is accepted."""
        self._model.accept_step()
        return self._model.state().history

    def _each(self) -> Iterator[tuple[Perturbation, Change, float]]:
        """Perturbations with what is known of their changes, and by how much they are taken."""
        for perturbation, change in zip(self._perturbations, self.changes, strict=True):
            amount = CHANGE * perturbation.scale * perturbation.direction
            yield perturbation, change, amount


def _rate(there: np.ndarray, here: np.ndarray, amount: float) -> np.ndarray:
    """Difference quotient; 0 if pairs of contact change, as there is no derivative."""
    if there.shape != here.shape or here.dtype.kind != "f":
        return np.zeros(here.shape)
    return np.asarray((there - here) / amount)

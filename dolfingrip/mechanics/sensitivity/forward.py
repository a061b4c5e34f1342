"""How a model's states change with its parameters, along the whole load path: forward mode."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.state import State

SMALL: Final = 1e-7
"""Part of a parameter's scale by which a model is perturbed. The residual of a solution is 0 to
Newton's tolerance, so that a one-sided difference is good to this part, and rounding to 1e-6."""

Readings = Mapping[str, float]


class Perturbation(Protocol):
    """A direction in the space of all that a model is built from.

    Attributes:
        scale: an ordinary change of the parameter, in its unit.
    """

    scale: float

    @property
    def way(self) -> float:
        """1, or −1 where only smaller values are allowed."""
        ...

    def applied(self, amount: float) -> AbstractContextManager[None]:
        """The model as it is with the parameter changed by ``amount``, for as long as entered."""
        ...


@dataclass(slots=True)
class Change:
    """Derivatives of a model's state by one parameter.

    Attributes:
        unknowns: local array (mm for each unit of the parameter).
        history: internal variables by name.
    """

    unknowns: np.ndarray
    history: dict[str, np.ndarray] = field(default_factory=dict)


class ForwardSensitivity:
    """Derivatives of all states on a load path by several parameters.

    At an accepted step the state x satisfies R(x; x₀, h₀, m) = 0, and the internal variables
    become h = H(x; x₀, h₀, m), with x₀ and h₀ those of the step's start. So

        K dx = −(∂R/∂m + ∂R/∂x₀ dx₀ + ∂R/∂h₀ dh₀),

    and dh follows from H's derivative (Michaleris, Tortorelli & Vidal, Int. J. Numer. Methods Eng.
    37, 1994). The bracket is one difference of R: the model is led to a start that is perturbed
    along (dx₀, dh₀) with a perturbed parameter, by the same calls as any step is, so that every
    term, memory and control takes part and none is named here. K is the tangent of the converged
    state, factorised once for all parameters.

    Args:
        model: at rest, as its path is.
        linear: makes K⁻¹ at the model's present state, for owned arrays in the order of a vector.
        perturbations: one for each parameter.

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
        rest = model.unknowns.local()
        self._derived: np.ndarray | None = None
        self.changes = [Change(np.zeros_like(rest)) for _ in perturbations]

    # -- along the path --------------------------------------------------------------------------

    def converged(self, before: State) -> None:
        """Take note of a converged load step from ``before``, not accepted yet.

        Without history the last step alone tells all, so it is derived when asked for.
        """
        self._before = before
        if before.history:
            self._advance(before)

    def readings(self, read: Callable[[], Readings]) -> list[dict[str, float]]:
        """Derivatives of readings at the present, accepted state, by parameter.

        Args:
            read: readings of the model as it is, all of them differentiable.

        Returns:
            For each parameter the derivative of each reading, for each unit of the parameter.
        """
        state = self._model.state()
        here = self._model.unknowns.local()
        if not state.history and not self._is_derived(here):
            self._advance(self._before or state)
        base = read()
        found = []
        for perturbation, change in self._each():
            amount = SMALL * perturbation.scale * perturbation.way
            with perturbation.applied(amount):
                self._led(state, state, change, amount)
                there = read()
            found.append({name: (there[name] - base[name]) / amount for name in base})
        self._model.restore(state)
        return found

    def _is_derived(self, here: np.ndarray) -> bool:
        """Whether the derivatives at hand are those of the unknowns ``here``, on all ranks."""
        same = self._derived is not None and np.array_equal(self._derived, here)
        return bool(self._model.comm.allreduce(same, MPI.LAND))

    # -- one step --------------------------------------------------------------------------------

    def _advance(self, before: State) -> None:
        """Derive the present, converged state from the derivatives at ``before``."""
        model = self._model
        now = model.state()
        here = model.unknowns.local()
        self._derived = here
        solve = self._linear()
        start = model.gradient()
        right = np.empty((len(start), len(self._perturbations)), order="F")
        for i, (perturbation, change) in enumerate(self._each()):
            amount = SMALL * perturbation.scale * perturbation.way
            with perturbation.applied(amount):
                self._led(before, now, change, amount)
                model.unknowns.set_local(here)
                right[:, i] = (model.gradient() - start) / amount
        steps = -solve(right)
        after = self._accepted(before, now, Change(here), 0.0, here) if before.history else {}
        for i, (perturbation, change) in enumerate(self._each()):
            amount = SMALL * perturbation.scale * perturbation.way
            unknowns = model.unknowns.to_local(steps[:, i])
            if before.history:
                with perturbation.applied(amount):
                    there = self._accepted(before, now, change, amount, here + amount * unknowns)
                change.history = {k: (there[k] - after[k]) / amount for k in after}
            change.unknowns = unknowns
        model.restore(before)
        model.prescribe(now.controls)
        model.unknowns.set_local(here)

    def _each(self) -> Iterator[tuple[Perturbation, Change]]:
        return zip(self._perturbations, self.changes, strict=True)

    def _led(self, before: State, now: State, change: Change, amount: float) -> None:
        """Begin the step at a start perturbed by ``amount`` along ``change``."""
        start = before.copy()
        model = self._model
        model.restore(start)
        if amount:
            perturbed = model.unknowns.local() + amount * change.unknowns
            start.history = {
                name: values + amount * change.history.get(name, 0.0)
                for name, values in before.history.items()
            }
            model.unknowns.set_local(perturbed)
            at = model.state()
            start.displacement, start.pressure, start.numbers = (
                at.displacement, at.pressure, at.numbers
            )  # fmt: skip
            model.restore(start)
        model.prescribe(now.controls)

    def _accepted(
        self, before: State, now: State, change: Change, amount: float, at: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Internal variables at the end of the step, perturbed, with the unknowns ``at``."""
        self._led(before, now, change, amount)
        self._model.unknowns.set_local(at)
        self._model.accept_step()
        return self._model.state().history

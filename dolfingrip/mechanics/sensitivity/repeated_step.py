"""A converged load step is taken again from a perturbed start or with a changed parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.state import State


class Perturbation(Protocol):
    """A direction in the space of all numbers that a model is built from.

    Attributes:
        scale: an ordinary change of the parameter, in its unit.
    """

    scale: float

    @property
    def direction(self) -> float:
        """1, or −1 if only smaller values are allowed."""
        ...

    def applied(self, amount: float) -> AbstractContextManager[None]:
        """A context in which the model's parameter has changed by ``amount``."""
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


class RepeatedStep:
    """A converged load step that is taken again, perturbed.

    Args:
        model: in the state at its end.
        before, now: states at its start and its end.
        here: unknowns at its end, as a local array.
        history: internal variables at its start that derivatives are of; those of ``before`` where
            None.
    """

    def __init__(
        self,
        model: Model,
        before: State,
        now: State,
        here: np.ndarray,
        history: Mapping[str, np.ndarray] | None,
    ) -> None:
        self._model = model
        self._before = before
        self._history = before.history if history is None else history
        self._now = now
        self._here = here
        solved = {id(unknown.constant) for unknown in model.unknowns.global_unknowns}
        self._results = {
            name
            for name, control in model.controls.items()
            if isinstance(control, Control) and id(control.constant) in solved
        }

    def controlled(self, state: State) -> dict[str, float]:
        """Controls of a state without those that are solved for, as a multiplier is."""
        return {k: value for k, value in state.controls.items() if k not in self._results}

    def begin(self, change: Change | None, amount: float) -> None:
        """Begin the step at a start that is perturbed by ``amount`` along ``change``."""
        model = self._model
        model.restore(self._before)
        history = dict(self._history)
        if change is not None:
            model.unknowns.set_local(model.unknowns.local() + amount * change.unknowns)
            history |= {
                name: values + amount * change.history[name]
                for name, values in history.items()
                if name in change.history and values.dtype.kind == "f"
            }
        start = model.state()
        start.controls, start.history = self.controlled(self._before), history
        model.restore(start)
        model.prescribe(self.controlled(self._now))

    def at_end[T](
        self,
        evaluate: Callable[[], T],
        perturbation: Perturbation | None = None,
        change: Change | None = None,
        amount: float = 0.0,
        along: np.ndarray | float = 0.0,
    ) -> T:
        """Evaluate at the end of the step, with the parameter changed.

        Args:
            evaluate: called with the model there.
            perturbation: of the parameter; None: it stays.
            change: derivatives of the step's start, which moves along it; None: it stays.
            amount: by which the parameter is changed.
            along: the end's unknowns move by ``amount`` times this local array.
        """
        with nullcontext() if perturbation is None else perturbation.applied(amount):
            self.begin(change, amount)
            self._end_at(self._here + amount * along)
            return evaluate()

    def placed(self, amount: float) -> np.ndarray:
        """How dependent displacements have moved with the mesh, for each unit; 0 elsewhere.

        Call it after :meth:`at_end` without a direction. The tangent leaves this motion out.
        """
        unknowns = self._model.unknowns
        return unknowns.owned_part(unknowns.local() - self._here) / amount

    def _end_at(self, there: np.ndarray) -> None:
        """Set the step's end, dependent displacements included."""
        self._model.unknowns.set_local(there)
        self._model.enforce_constraint()
        self._model.update_lagged()

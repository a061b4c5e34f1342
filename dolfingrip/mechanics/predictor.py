"""Where Newton's method starts a load step."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from dolfingrip.mechanics.model import Model

MOST, FEWEST = 4, 3
"""States that the polynomial goes through: at most, so cubic, and at least."""

CLEAR = 0.9
"""Part of the way to a bound that is taken: on it the barrier would be felt too much."""

WORTH = 0.3
"""A shorter part of the way to the state ahead saves no iteration."""


@dataclass(frozen=True, slots=True)
class Guess:
    """A start of Newton's method.

    Attributes:
        unknowns: of the model, as a local array.
        stress: values of its carried stress.
    """

    unknowns: np.ndarray
    stress: np.ndarray


class Predictor:
    """Continues the polynomial through the last states of a straight load path.

    Displacement *and* carried stress are extrapolated: the stress barely feels that the
    extrapolated displacement stretches what should merely turn, and with it the first tangent is
    nearly that of the solution. Displacement alone costs more iterations than it saves.

    Args:
        model: whose states are kept; without a carried stress nothing is predicted.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._kept: deque[tuple[float, Guess]] = deque(maxlen=MOST)

    def restart(self, place: float) -> None:
        """Forget all but the present, converged state at ``place`` on the path."""
        self._kept.clear()
        if self._model.potential.carried is not None:
            self._model.potential.carried.reset()
            self.keep(place)

    def keep(self, place: float) -> None:
        """Remember the state that Newton's method has found at ``place``."""
        carried = self._model.potential.carried
        if carried is not None:
            guess = Guess(self._model.unknowns.local(), carried.stress.x.array.copy())
            self._kept.append((place, guess))

    def guess(self, place: float) -> Guess | None:
        """The state at ``place``, or close to it as far as the bounds let; None if not far."""
        if len(self._kept) < FEWEST:
            return None
        places = np.array([kept for kept, _ in self._kept])
        weights = lagrange(places, place)
        states = [state for _, state in self._kept]
        last = states[-1]
        step = np.tensordot(weights, [state.unknowns for state in states], 1) - last.unknowns
        part, _ = self._model.admissible_step(step)
        if part < 1.0:
            part *= CLEAR
        if part < WORTH:
            return None
        stress = np.tensordot(weights, [state.stress for state in states], 1)
        return Guess(last.unknowns + part * step, last.stress + part * (stress - last.stress))


def lagrange(places: np.ndarray, place: float) -> np.ndarray:
    """(n,) weights with which values at ``places`` (n,) make the polynomial's at ``place``."""
    apart = places[:, None] - places + np.eye(len(places))
    ratios = (place - places) / apart
    np.fill_diagonal(ratios, 1.0)
    return np.asarray(ratios.prod(axis=1))

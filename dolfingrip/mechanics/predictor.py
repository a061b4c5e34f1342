"""Where Newton's method starts a load step."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from dolfingrip.mechanics.model import Model

MOST, FEWEST = 4, 3
"""States that the polynomial goes through: at most, so cubic, and at least."""


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
        """The state at ``place``; None where too few are known or a bound lies on the way."""
        if len(self._kept) < FEWEST:
            return None
        places = np.array([kept for kept, _ in self._kept])
        weights = lagrange(places, place)
        states = [state for _, state in self._kept]
        unknowns = np.tensordot(weights, [state.unknowns for state in states], 1)
        if self._model.admissible_step(unknowns - states[-1].unknowns)[0] < 1.0:
            return None
        return Guess(unknowns, np.tensordot(weights, [state.stress for state in states], 1))


def lagrange(places: np.ndarray, place: float) -> np.ndarray:
    """(n,) weights with which values at ``places`` (n,) make the polynomial's at ``place``."""
    apart = places[:, None] - places + np.eye(len(places))
    ratios = (place - places) / apart
    np.fill_diagonal(ratios, 1.0)
    return np.asarray(ratios.prod(axis=1))

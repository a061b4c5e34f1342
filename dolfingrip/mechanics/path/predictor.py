"""The state from which Newton's method starts a load step."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping

import numpy as np

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.state import Guess
from dolfingrip.mechanics.path import series
from dolfingrip.mechanics.path.policy import PathPolicy


class Predictor:
    """Continues the polynomial through the last states of a straight load path.

    At the start of the path the states are those of its series. Displacement *and* carried stress
    are extrapolated. The extrapolated displacement stretches parts that should only turn, but this
    hardly affects the extrapolated stress, with which the first tangent is nearly that of the
    solution. Extrapolating the displacement alone costs more iterations than it saves.

    Args:
        model: model whose states are kept; nothing is predicted if its tangent carries nothing.
        tangent: returns K⁻¹ at the model's state, for :func:`series.terms`.
        policy: policy of the path.
    """

    def __init__(
        self, model: Model, tangent: Callable[[], series.Solve], policy: PathPolicy
    ) -> None:
        self._model = model
        self._tangent = tangent
        self._series = policy.series
        self._policy = policy.predictor
        self._kept: deque[tuple[float, Guess]] = deque(maxlen=self._policy.most)

    def restart(self, place: float) -> None:
        """Forget all states except the present, converged one at ``place`` on the path."""
        self._kept.clear()
        self._model.carried.reset()
        self.keep(place)

    def turn(self, place: float, rates: Mapping[str, float]) -> float:
        """Start a new straight path at the present, converged state.

        Args:
            place: place of the state on the path.
            rates: rates of the controls, for each unit of place.

        Returns:
            The length of a first step that is easy, at most 1.
        """
        self.restart(place)
        state = self._model.state()
        if not self._model.carried or state.history:
            return 1.0  # if internal variables evolve, half a step ends in another state
        terms = series.terms(self._model, self._tangent, state.controls, rates, self._series)
        if not terms:
            return 1.0
        reach = series.reach(self._model, terms, self._series.falling)
        if reach < 1.0:
            reach = series.reach(self._model, terms, self._series.easy)
        here = self._model.unknowns.local()
        farthest = series.along(here, terms, self._policy.ahead[0] * reach)
        if reach < self._series.nearest or self._model.admissible_step(farthest - here)[0] < 1.0:
            return 1.0
        self._kept.clear()
        for ahead in (*self._policy.ahead, 0.0):
            self._model.unknowns.set_local(series.along(here, terms, ahead * reach))
            self._model.carried.reset()
            self.keep(place + ahead * reach)
        return reach

    def keep(self, place: float) -> None:
        """Store the state that Newton's method has found at ``place``."""
        carried = self._model.carried
        if carried:
            guess = Guess(self._model.unknowns.local(), carried.values)
            self._kept.append((place, guess))

    def guess(self, place: float) -> Guess | None:
        """The state at ``place``, or as near to it as bounds allow; None if that is not far."""
        if len(self._kept) < self._policy.fewest:
            return None
        places = np.array([kept for kept, _ in self._kept])
        weights = lagrange(places, place)
        states = [state for _, state in self._kept]
        last = states[-1]
        step = np.tensordot(weights, [state.unknowns for state in states], 1) - last.unknowns
        part, _ = self._model.admissible_step(step)
        if part < 1.0:
            part *= self._policy.clear
        if part < self._policy.worth:
            return None
        carried = np.tensordot(weights, [state.carried for state in states], 1)
        return Guess(last.unknowns + part * step, last.carried + part * (carried - last.carried))


def lagrange(places: np.ndarray, place: float) -> np.ndarray:
    """(n,) weights of values at ``places`` (n,) in the interpolating polynomial at ``place``."""
    apart = places[:, None] - places + np.eye(len(places))
    ratios = (place - places) / apart
    np.fill_diagonal(ratios, 1.0)
    return np.asarray(ratios.prod(axis=1))

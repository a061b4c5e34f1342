"""When terms take anew what they hold while their potential is minimised."""

from __future__ import annotations

from dolfingrip.mechanics.model.model import Model

FALLEN = 0.5
"""Part of the residual after the last time to which it falls before the next."""

CLOSE = 1e-3
"""Part of its peak below which terms hold what they have, unless it drifts: then Newton's method
converges."""

DRIFTS = 0.01
"""Relative change of what is held above which it is too old, and a converged state is none."""

AGAIN = 5
"""How often in one solve."""


class Refreshing:
    """Rules of one solve.

    What terms hold (friction its normal forces and tangent planes) is a function of the solution,
    so it follows the iterates at first. It does not follow an overshoot, whose contact forces may
    be many times too large: only where the residual has fallen since the last time. Close to the
    solution it is held as long as it does not drift, which is checked once more at the end.

    Args:
        model: whose terms hold something.

    Attributes:
        most: drift above which it is too old; :data:`DRIFTS` at first.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self.most = DRIFTS
        self.start()

    def start(self) -> None:
        """Forget the last solve."""
        self._peak_N = self._last_N = 0.0
        self._held = False
        self._repeats = 0

    @property
    def lost(self) -> bool:
        """Whether what is held drifts however often the state is solved for again."""
        return self._repeats > AGAIN

    def follows(self, norm: float, first_N: float) -> bool:
        """Whether terms are to take anew what they hold, at an iterate that goes on.

        Args:
            norm: of the residual (N).
            first_N: that of the solve's start.
        """
        self._peak_N = max(self._peak_N, norm, first_N)
        fallen = norm <= FALLEN * (self._last_N or first_N)
        due = fallen and (not self._held or self._model.drift() > self.most)
        self._held |= norm <= CLOSE * self._peak_N
        return due

    def drifts(self) -> bool:
        """Whether they are to do so where the solve has converged."""
        drifted = self._model.drift() > self.most
        self._repeats += drifted
        return drifted

    def done(self, norm: float) -> None:
        """Take note of the residual (N) once they have."""
        self._last_N = norm

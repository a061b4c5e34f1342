"""When terms update what their potential holds fixed while it is minimised."""

from __future__ import annotations

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.policy import LagPolicy


class LagRules:
    """Rules of one solve.

    Lagged quantities (friction's normal forces and tangent planes) are functions of the solution,
    so they are updated with the iterates at first. A corrected step is one that is solved for with
    their change along it; they are updated where it ends, unless it overshoots. Then, and after any
    other step, which may overshoot, too, they are updated only where the residual has fallen since
    the last update. Close to the solution they are kept as long as their lag error is small, which
    is checked once more at the end.

    Args:
        model: whose terms have lagged quantities.
        policy: when they are updated.

    Attributes:
        current: they are those of the present iterate, so that the next step may be corrected.
        corrected: the last step was; Newton's method says so.
        overshot: a corrected step made the residual grow too much.
    """

    def __init__(self, model: Model, policy: LagPolicy) -> None:
        self._model = model
        self._policy = policy
        self.start()

    def start(self, *, predicted: bool = False, corrected: bool = True) -> None:
        """Forget the last solve.

        Args:
            predicted: the next one starts at an estimate of its solution, not at the last one.
            corrected: steps may be corrected.
        """
        self._peak_N = self._last_N = 0.0
        self._kept = self.current = self.corrected = self.overshot = False
        self._predicted = predicted
        self._repeats, self._corrections = 0, 0 if corrected else self._policy.longest

    @property
    def lost(self) -> bool:
        """Whether quantities lag too far however often the state is solved for again."""
        return self._repeats > self._policy.again

    def is_due(self, norm: float, first_N: float) -> bool:
        """Whether terms are to update their quantities, at an iterate that goes on.

        Args:
            norm: of the residual (N).
            first_N: that of the solve's start.
        """
        at_start = self._peak_N == 0.0
        self._peak_N = max(self._peak_N, norm, first_N)
        fallen = norm <= self._policy.fallen * (self._last_N or first_N)
        self._corrections += self.corrected
        if self.corrected and 0 < self._policy.overshot * self._last_N < norm:
            self.corrected, self.overshot, self._corrections = False, True, self._policy.longest
        due = self.corrected or (at_start and self._predicted)
        due = due or (fallen and (not self._kept or self._is_outdated()))
        self._kept |= norm <= self._policy.close * self._peak_N
        current = due or (at_start and not self._is_outdated())
        self.current = current and not self._kept and self._corrections < self._policy.longest
        self.corrected = False
        return due

    def is_due_at_the_end(self) -> bool:
        """Whether they are to do so where the solve has converged."""
        outdated = self._is_outdated()
        self._repeats += outdated
        return outdated

    def _is_outdated(self) -> bool:
        return self._model.lag_error() > self._policy.tolerance

    def updated(self, norm: float) -> None:
        """Take note of the residual (N) once they have."""
        self._last_N = norm

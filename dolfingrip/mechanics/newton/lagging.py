"""Rules that decide when terms update their lagged quantities."""

from __future__ import annotations

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.policy import LagPolicy


class LagRules:
    """The rules of one solve.

    Lagged quantities (friction's normal forces and tangent planes) are functions of the solution,
    so they are updated in the first iterations. The equations of a corrected step contain their
    change along the step. They are updated at its end, unless the step overshoots. After a step
    that overshoots, and after any other step, which may also overshoot, they are updated only if
    the residual has fallen since the last update. Close to the solution they are kept as long as
    their lag error is small, which is checked again at the end.

    Args:
        model: model whose terms have lagged quantities.
        policy: when they are updated.

    Attributes:
        current: whether they are those of the present iterate; only then may the next step be
            corrected.
        corrected: whether the last step was corrected; Newton's method sets this.
        overshot: whether a corrected step made the residual grow too much.
    """

    def __init__(self, model: Model, policy: LagPolicy) -> None:
        self._model = model
        self._policy = policy
        self.start()

    def start(self, *, predicted: bool = False, corrected: bool = True) -> None:
        """Forget the last solve.

        Args:
            predicted: whether the next solve starts at an estimate of its solution, not at the last
                solution.
            corrected: whether steps may be corrected.
        """
        self._peak_N = self._last_N = 0.0
        self._kept = self.current = self.corrected = self.overshot = False
        self._predicted = predicted
        self._repeats, self._corrections = 0, 0 if corrected else self._policy.longest

    @property
    def lost(self) -> bool:
        """Whether quantities still lag too far after the state was solved for several times."""
        return self._repeats > self._policy.again

    def is_due(self, norm: float, first_N: float) -> bool:
        """Whether terms must update their quantities at an iterate that is not the last.

        Args:
            norm: norm of the residual (N).
            first_N: norm at the solve's start.
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
        """Whether terms must update their quantities after the solve has converged."""
        outdated = self._is_outdated()
        self._repeats += outdated
        return outdated

    def _is_outdated(self) -> bool:
        return self._model.lag_error() > self._policy.tolerance

    def updated(self, norm: float) -> None:
        """Store the residual (N) after an update."""
        self._last_N = norm

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

OVERSHOT = 5.0
"""Growth of the residual since the last time in a step that what is held has followed, from which
on it follows no more: a contact force may then be a hundred times too large. A solve's first step
may be as large as it likes."""

LONGEST = 8
"""Steps of one solve that what is held follows. Where more are needed they go astray, and what is
held while the residual falls to half is the safer way."""

AGAIN = 5
"""How often in one solve."""


class Refreshing:
    """Rules of one solve.

    What terms hold (friction its normal forces and tangent planes) is a function of the solution,
    so it follows the iterates at first. A step that is solved for with what is held following it
    ends where that is taken anew, unless it overshoots; then, and after any other, which may
    overshoot, too, only where the residual has fallen since the last time. Close to the solution
    it is held as long as it does not drift, which is checked once more at the end.

    Args:
        model: whose terms hold something.

    Attributes:
        fresh: what is held is that of the present iterate, and may follow the next step.
        followed: it has followed the last step; Newton's method says so.
        overshot: a step that it followed made the residual grow too much.
        most: drift above which it is too old; :data:`DRIFTS` at first.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self.most = DRIFTS
        self.start()

    def start(self, *, predicted: bool = False, following: bool = True) -> None:
        """Forget the last solve.

        Args:
            predicted: the next one starts at an estimate of its solution, not at the last one.
            following: what is held may follow steps.
        """
        self._peak_N = self._last_N = 0.0
        self._held = self.fresh = self.followed = self.overshot = False
        self._predicted = predicted
        self._repeats, self._followed = 0, 0 if following else LONGEST

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
        at_start = self._peak_N == 0.0
        self._peak_N = max(self._peak_N, norm, first_N)
        fallen = norm <= FALLEN * (self._last_N or first_N)
        self._followed += self.followed
        if self.followed and 0 < OVERSHOT * self._last_N < norm:
            self.followed, self.overshot, self._followed = False, True, LONGEST
        due = self.followed or (at_start and self._predicted)
        due = due or (fallen and (not self._held or self._model.drift() > self.most))
        self._held |= norm <= CLOSE * self._peak_N
        current = due or (at_start and self._model.drift() <= self.most)
        self.fresh = current and not self._held and self._followed < LONGEST
        self.followed = False
        return due

    def drifts(self) -> bool:
        """Whether they are to do so where the solve has converged."""
        drifted = self._model.drift() > self.most
        self._repeats += drifted
        return drifted

    def done(self, norm: float) -> None:
        """Take note of the residual (N) once they have."""
        self._last_N = norm

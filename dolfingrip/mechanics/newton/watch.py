"""What a solve that takes long tells while it goes on."""

from __future__ import annotations

import time
from collections.abc import Callable

from dolfingrip.mechanics.model.compilation import Tell
from dolfingrip.mechanics.newton.policy import WATCH


class Watch:
    """Tells of each iteration of a solve that takes longer than two seconds.

    Args:
        clock: in seconds.

    Attributes:
        tell: receives each line; None: nothing is told.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self.tell: Tell | None = None
        self.start()

    def start(self) -> None:
        """A new solve begins."""
        self._began_s = self._clock()
        self._step = ""

    def stepped(self, fraction: float, bound: str) -> None:
        """A step is taken: the part of Newton's step, and the name of what bounds it."""
        self._step = f", step {fraction:.2g} of Newton's"
        if bound:
            self._step += f", bounded by: {bound}"

    def judged(self, iteration: int, norm_N: float, tolerance_N: float) -> None:
        """The residual after so many iterations is known."""
        if self.tell is not None and self._clock() - self._began_s > WATCH.patience_s:
            residual = f"residual {norm_N:.1e} N (to {tolerance_N:.1e} N)"
            self.tell(f"iteration {iteration}: {residual}{self._step}")

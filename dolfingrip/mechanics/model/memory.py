"""What a model remembers from its last accepted state besides the displacement."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


class Memory:
    """Something with a memory: a term, internal variables, a line that supplies pressure.

    A memory overrides the methods that it needs; the inherited ones do nothing.
    """

    def set_time(self, time_s: float, step_s: float) -> None:
        """Take note of the time at the load step's end and of the step's length (s)."""

    def accept(self) -> None:
        """The load step has converged: what is remembered becomes that of its end."""

    def values(self) -> dict[str, np.ndarray]:
        """Copies of what is remembered, by name."""
        return {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Remember what :meth:`values` gave."""

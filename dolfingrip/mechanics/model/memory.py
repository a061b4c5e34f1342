"""Memory of a model from its last accepted state, in addition to the displacement."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


class Memory:
    """Something with a memory: a term, internal variables, a line that supplies pressure.

    A memory overrides the methods that it needs; the inherited ones do nothing.
    """

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the time at the load step's end and the step's length (s)."""

    def accept(self) -> None:
        """Store the values at the end of a load step that has converged."""

    def values(self) -> dict[str, np.ndarray]:
        """Copies of the stored values, by name."""
        return {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore values that :meth:`values` returned."""

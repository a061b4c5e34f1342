"""The state of a model between load steps, and what remembers a part of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, slots=True)
class Guess:
    """An estimate from which Newton's method starts.

    Attributes:
        unknowns: local array of the model's unknowns.
        carried: values of the fields that its tangent carries along.
    """

    unknowns: np.ndarray
    carried: np.ndarray


@dataclass(slots=True)
class State:
    """A point on a load path that can be copied, restored and stored.

    Attributes:
        displacement: this rank's displacement dofs, ghosts included (mm).
        controls: prescribed quantities by name, in the unit of the name (``pressure_kPa``,
            ``time_s``).
        pressure: this rank's dofs of a mixed model's pressure field, ghosts included (MPa).
        global_unknowns: global unknowns by name with unit.
        history: internal variables by name, this rank's values.
    """

    displacement: np.ndarray
    controls: dict[str, float]
    pressure: np.ndarray | None = None
    global_unknowns: dict[str, float] = field(default_factory=dict)
    history: dict[str, np.ndarray] = field(default_factory=dict)

    def copy(self) -> State:
        """A copy that shares no data with this state."""
        return State(
            self.displacement.copy(),
            dict(self.controls),
            None if self.pressure is None else self.pressure.copy(),
            dict(self.global_unknowns),
            {name: values.copy() for name, values in self.history.items()},
        )


class Memory:
    """Something with a memory: a term, internal variables, a line that supplies pressure.

    A memory overrides the methods that it needs; the inherited ones do nothing.
    """

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the time at the load step's end and the step's length (s)."""

    def step_error(self) -> float:
        """Error of a converged load step by the allowed one, the same on all ranks; 0 if none."""
        return 0.0

    def accept(self) -> None:
        """Store the values at the end of a load step that has converged."""

    def values(self) -> dict[str, np.ndarray]:
        """Copies of the stored values, by name."""
        return {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore values that :meth:`values` returned."""

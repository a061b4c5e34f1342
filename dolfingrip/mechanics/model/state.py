"""The state of a model between load steps."""

from __future__ import annotations

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

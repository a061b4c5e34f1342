"""The supply from the regulator to the cavity: a control whose stages are effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from dolfingrip.channels import PRESSURE
from dolfingrip.extensions.effect import Flow, Stage
from dolfingrip.mechanics.model.model import Prescribed
from dolfingrip.mechanics.model.state import Memory


class Supply(Memory):
    """The control of a path: the regulator's pressure, from which stages make the cavity's.

    It is a control and also a memory of the model: the pressure at each stage at the load step's
    start is part of the state.

    Args:
        cavity: the cavity's pressure, or what its supply of air is asked for.
        stages: effects on the pressure, from regulator to cavity.
        name: of the control; the memory has the same.
    """

    def __init__(
        self, cavity: Prescribed, stages: Sequence[Stage], name: str = PRESSURE.name
    ) -> None:
        self._cavity, self._name = cavity, f"supply of {name}"
        self.stages = stages
        self._regulator_kPa = 0.0
        # no pressure behind a stage is known at first
        self._before = self._pass(np.full(len(stages) + 1, np.nan), 0.0, 0.0)
        self._now = self._before.copy()
        cavity.set(self._now[-1])

    def _pass(self, before: np.ndarray, time_s: float, step_s: float) -> np.ndarray:
        """Pressure at the regulator and behind each stage; ``before`` is NaN if unknown."""
        now = np.full_like(before, self._regulator_kPa)
        for i, stage in enumerate(self.stages):
            earlier = np.where(np.isnan(before[i : i + 2]), now[i], before[i : i + 2])
            flow = Flow(float(earlier[0]), float(now[i]), float(earlier[1]), time_s, step_s)
            now[i + 1] = stage.outlet_kPa(flow)
        return now

    # -- as a control ----------------------------------------------------------------------------

    @property
    def value(self) -> float:
        """Pressure at the regulator (kPa)."""
        return self._regulator_kPa

    def set(self, value: float) -> None:
        """Prescribe ``value`` at the regulator; the cavity's pressure follows with time."""
        self._regulator_kPa = value

    # -- as a memory -----------------------------------------------------------------------------

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the cavity's pressure at the load step's end."""
        self._now = self._pass(self._before, time_s, step_s)
        self._cavity.set(self._now[-1])

    def accept(self) -> None:
        """Store the present pressures as the pressures at the next load step's start."""
        self._before = self._now.copy()

    def values(self) -> dict[str, np.ndarray]:
        """Pressure at the regulator and behind each stage at the step's start, if any counts."""
        counts = any(stage.follows_path() for stage in self.stages)
        return {self._name: self._before.copy()} if counts else {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore the pressure at each stage."""
        self._before = values.get(self._name, self._before).copy()

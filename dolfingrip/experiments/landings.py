"""The states at which an experiment is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from dolfingrip.config import Config
from dolfingrip.mechanics.state import State

Branch = Literal["loading", "unloading"]


@dataclass(frozen=True, slots=True)
class Landing:
    """A reading's place on the path.

    Attributes:
        part: of the way from rest (0) to the maximum (1).
        branch: ``loading`` or ``unloading``.
        pressure_kPa: prescribed there; None where the volume is.
    """

    part: float
    branch: Branch
    pressure_kPa: float | None

    def controls(self, config: Config, rest: State, time_s: float) -> Mapping[str, float]:
        """Controls to go to, by name; ``rest`` is the unpressurised state."""
        if self.pressure_kPa is not None:
            return {"pressure_kPa": self.pressure_kPa, "time_s": time_s}
        ratio = 1 + self.part * (config.experiment.max_volume_ratio - 1)
        volume = rest.controls["cavity_volume_mm3"] * ratio
        return {"cavity_volume_mm3": volume, "time_s": time_s}


def landings(config: Config) -> Sequence[Landing]:
    """Readings from rest in steps to the maximum, and back where asked."""
    experiment = config.experiment
    by_pressure = experiment.control == "pressure"
    if by_pressure:
        largest, step = experiment.max_pressure_kPa, experiment.step_kPa
    else:
        largest, step = experiment.max_volume_ratio - 1, experiment.step_volume_ratio
    count = int(largest / step + 1e-9)
    values = [i * step for i in range(count + 1)]
    if largest - values[-1] > 1e-9 * largest:
        values.append(largest)

    def at(value: float, branch: Branch) -> Landing:
        return Landing(value / largest, branch, value if by_pressure else None)

    up = [at(value, "loading") for value in values]
    down = [at(value, "unloading") for value in values[-2::-1]] if experiment.unload else []
    return up + down


def landings_kPa(config: Config) -> Sequence[float]:
    """Prescribed pressures in order; none where the volume is prescribed."""
    pressures = (landing.pressure_kPa for landing in landings(config))
    return [pressure for pressure in pressures if pressure is not None]

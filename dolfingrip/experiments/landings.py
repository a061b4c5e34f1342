"""The states at which a finger is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dolfingrip.config import Branch, Config, ConfigError
from dolfingrip.experiments import schedule
from dolfingrip.mechanics.model.state import State


@dataclass(frozen=True, slots=True)
class Landing:
    """A reading's place on the path.

    Attributes:
        part: of the way from rest (0) to the maximum (1); NaN in a protocol.
        branch: ``loading``, ``unloading`` or ``hold``.
        pressure_kPa: prescribed there; None where the volume is.
        time_s: since the first reading.
        cycle: from 1 on.
    """

    part: float
    branch: Branch
    pressure_kPa: float | None
    time_s: float
    cycle: int

    def controls(self, config: Config, rest: State) -> Mapping[str, float]:
        """Controls to go to, by name; ``rest`` is the unpressurised state."""
        if self.pressure_kPa is not None:
            return {"pressure_kPa": self.pressure_kPa, "time_s": self.time_s}
        ratio = 1 + self.part * (config.experiment.max_volume_ratio - 1)
        volume = rest.controls["cavity_volume_mm3"] * ratio
        return {"cavity_volume_mm3": volume, "time_s": self.time_s}


def landings(config: Config) -> Sequence[Landing]:
    """Readings of the protocol, else from rest in steps to the maximum, and back where asked.

    Raises:
        ConfigError: the protocol is none for a finger.
    """
    experiment, protocol = config.experiment, config.protocol
    by_pressure = experiment.control == "pressure"
    if protocol.time_s:
        if not protocol.pressure_kPa:
            raise ConfigError("protocol.pressure_kPa = []: allowed: a pressure for each time_s")
        found = schedule.given(protocol, protocol.pressure_kPa)
        largest = float("nan")
    elif by_pressure:
        largest = experiment.max_pressure_kPa
        values = schedule.steps(largest, experiment.step_kPa)
        found = schedule.cycles(values, experiment.rate_kPa_per_s, experiment)
    else:
        largest = experiment.max_volume_ratio - 1
        values = schedule.steps(largest, experiment.step_volume_ratio)
        # a step of the volume takes as long as one of the pressure would
        seconds = experiment.step_kPa / experiment.rate_kPa_per_s
        found = schedule.cycles(values, experiment.step_volume_ratio / seconds, experiment)
    return [
        Landing(
            reading.value / largest,
            reading.branch,
            reading.value if by_pressure else None,
            reading.time_s,
            reading.cycle,
        )
        for reading in found
    ]


def landings_kPa(config: Config) -> Sequence[float]:
    """Prescribed pressures in order; none where the volume is prescribed."""
    pressures = (landing.pressure_kPa for landing in landings(config))
    return [pressure for pressure in pressures if pressure is not None]

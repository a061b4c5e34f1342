"""How a finger is pressurised: under pressure control or volume control."""

from __future__ import annotations

from collections.abc import Sequence

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.protocol import schedule
from dolfingrip.experiments.protocol.schedule import Stop


def stops(config: Config) -> Sequence[Stop]:
    """Stops of the protocol, else from rest in steps to the maximum, and back where asked.

    The value is a pressure (kPa); under volume control, the cavity's growth relative to its rest.

    Raises:
        ConfigError: the protocol is none for a finger.
    """
    experiment, protocol = config.experiment, config.protocol
    if protocol.time_s:
        if not protocol.pressure_kPa:
            raise ConfigError("protocol.pressure_kPa = []: allowed: a pressure for each time_s")
        if not by_pressure(config):
            raise ConfigError(
                f'experiment.control = "{experiment.control}": allowed: "pressure" with a protocol'
            )
        return schedule.given(protocol, protocol.pressure_kPa)
    if by_pressure(config):
        values = schedule.steps(experiment.max_pressure_kPa, experiment.step_kPa)
        return schedule.cycles(values, experiment.rate_kPa_per_s, experiment)
    growths = schedule.steps(experiment.max_volume_ratio - 1, experiment.step_volume_ratio)
    # a step of the volume takes as long as one of the pressure would
    seconds = experiment.step_kPa / experiment.rate_kPa_per_s
    return schedule.cycles(growths, experiment.step_volume_ratio / seconds, experiment)


def by_pressure(config: Config) -> bool:
    """Whether the control is the pressure rather than the cavity's volume."""
    return config.experiment.control == "pressure"


def pressures_kPa(config: Config) -> Sequence[float]:
    """Prescribed pressures in order; none under volume control."""
    return [stop.value for stop in stops(config)] if by_pressure(config) else []

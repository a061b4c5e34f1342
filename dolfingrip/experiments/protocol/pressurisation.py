"""How a finger is pressurised: under pressure control or volume control."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from dolfingrip.channels import supply_of
from dolfingrip.experiments.protocol import schedule
from dolfingrip.experiments.protocol.schedule import Stop
from dolfingrip.sections.errors import ConfigError

if TYPE_CHECKING:
    from dolfingrip.config import Config

LEAST = 0.1
"""Part of a step of the volume: a reading that is nearer than this is left out."""

FURTHER = 2.0
"""Factor by which a cavity can grow after a limit point with the ratio that is advised."""


def stops(config: Config) -> Sequence[Stop]:
    """Return the stops of the protocol, or steps from rest to the maximum and back.

    The value of a stop is a pressure (kPa). Under volume control it is the cavity's growth, as a
    part of its volume at rest.

    Args:
        config: of the experiment.

    Raises:
        ConfigError: one line, if the protocol is not one for a finger.
    """
    experiment, protocol = config.experiment, config.protocol
    if protocol.time_s:
        if not protocol.pressure_kPa:
            raise ConfigError("protocol.pressure_kPa = []: allowed: a pressure for each time_s")
        if experiment.control != "pressure":
            raise ConfigError(
                f'experiment.control = "{experiment.control}": allowed: "pressure" with a protocol'
            )
        own = {supply_of(name).name: each for name, each in config.cavity.own.items()}
        return schedule.given(protocol, protocol.pressure_kPa, own)
    if by_pressure(config):
        most, least = experiment.max_pressure_kPa, experiment.min_pressure_kPa
        values, suction = (schedule.steps(end, experiment.step_kPa) for end in (most, least))
        return schedule.cycles(values, experiment.rate_kPa_per_s, experiment, suction)
    return schedule.cycles(_growths(config), _growth_rate(config), experiment)


def stops_by_volume(config: Config, growth: float, time_s: float) -> Sequence[Stop]:
    """Stops under volume control that come after the cavity has grown by ``growth``.

    Args:
        config: configuration with the largest cavity and the steps to it.
        growth: growth of the cavity, as a part of its volume at rest.
        time_s: present time.
    """
    rate, least = _growth_rate(config), LEAST * config.experiment.step_volume_ratio
    left = [value for value in _growths(config) if value > growth + least]
    return [Stop(value, time_s + (value - growth) / rate, "loading") for value in left]


def advice(config: Config, ratio: float) -> str:
    """The settings with which a finger under pressure control goes on by its cavity's volume.

    Args:
        config: configuration with the control and the largest cavity.
        ratio: volume of the cavity by its volume at rest.

    Returns:
        A sentence; "" with a protocol, which prescribes pressures, and where no setting helps.
    """
    experiment = config.experiment
    if config.protocol.time_s:
        return ""
    changes = []
    if experiment.control == "pressure":
        returns = experiment.unload or experiment.cycles > 1  # "auto" allows neither
        changes.append(f"control={'volume' if returns else 'auto'}")
    if ratio + experiment.step_volume_ratio >= experiment.max_volume_ratio:
        changes.append(f"max_volume_ratio={math.ceil(FURTHER * ratio)}")
    if not changes:
        return ""
    settings = " ".join(f"--set experiment.{change}" for change in changes)
    return f"the cavity is {ratio:.2g} times as large as at rest; it can grow on with {settings}"


def _growths(config: Config) -> list[float]:
    """Growths of the cavity, as parts of its volume at rest, in order."""
    experiment = config.experiment
    return schedule.steps(experiment.max_volume_ratio - 1, experiment.step_volume_ratio)


def _growth_rate(config: Config) -> float:
    """Growth in a second: a step of the volume takes as long as a step of the pressure."""
    experiment = config.experiment
    seconds = experiment.step_kPa / experiment.rate_kPa_per_s
    return experiment.step_volume_ratio / seconds


def by_pressure(config: Config) -> bool:
    """Return whether the control at the start is the pressure, not the cavity's volume.

    Args:
        config: of the experiment.
    """
    return config.experiment.control != "volume"


def pressures_kPa(config: Config) -> Sequence[float]:
    """Return the prescribed pressures (kPa) in order; none under volume control.

    Args:
        config: of the experiment.
    """
    return [stop.value for stop in stops(config)] if by_pressure(config) else []

"""The stops of an experiment: ramps, waits and cycles at given rates, or given times.

A finger is pressurised under pressure control or volume control. A grasp has stages: open and
approach if asked, pressurise, settle, lift, settle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from dolfingrip.channels import supply_of
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.procedure import branch_of
from dolfingrip.sections.protocol_file import waits

if TYPE_CHECKING:
    from dolfingrip.config import Config
    from dolfingrip.sections.procedure import Branch, ExperimentSettings, Protocol

    GraspBranch = Branch | Literal["approach", "lift"]


@dataclass(frozen=True, slots=True)
class Stop:
    """A point of the schedule at which readings are taken.

    Attributes:
        value: value of the control, in its unit.
        time_s: time since the first stop.
        branch: ``loading`` (away from 0), ``unloading`` (back towards 0), ``hold``, or ``approach``
            and ``lift`` of a grasp.
        cycle: number of the cycle, from 1 on.
        others: values of further controls, by name.
    """

    value: float
    time_s: float
    branch: GraspBranch
    cycle: int = 1
    others: Mapping[str, float] = field(default_factory=dict, hash=False)


def steps(largest: float, step: float) -> list[float]:
    """Values from 0 to ``largest``, of either sign, in steps; the last value is ``largest``."""
    size = abs(largest)
    signed = math.copysign(step, largest)
    values = [0.0 + i * signed for i in range(int(size / step + 1e-9) + 1)]
    if size - abs(values[-1]) > 1e-9 * size:
        values.append(largest)
    return values


def cycles(
    values: Sequence[float],
    rate: float,
    experiment: ExperimentSettings,
    before: Sequence[float] = (),
) -> list[Stop]:
    """Stops that go through ``values`` from rest, and back if asked, in each cycle.

    Args:
        values: values of the control from 0 on, whose size increases.
        rate: change of the value per second.
        experiment: number of cycles, waits, and whether to unload.
        before: values from 0 on that each cycle goes to and back from first, as of suction.
    """
    stops: list[Stop] = [Stop(values[0], 0.0, "loading")]

    def ramp(targets: Sequence[float], cycle: int) -> None:
        for value in targets:
            last = stops[-1]
            time_s = last.time_s + abs(value - last.value) / rate
            stops.append(Stop(value, time_s, branch_of(last.value, value), cycle))

    def wait(length_s: float, cycle: int) -> None:
        last = stops[-1]
        for after in waits(length_s, experiment.hold_readings, even=experiment.dynamic):
            stops.append(Stop(last.value, last.time_s + after, "hold", cycle))

    for cycle in range(1, experiment.cycles + 1):
        ramp(before[1:], cycle)
        ramp(before[-2::-1], cycle)
        ramp(values[1:], cycle)
        wait(experiment.hold_s, cycle)
        if experiment.unload or experiment.cycles > 1:
            ramp(values[-2::-1], cycle)
            wait(experiment.rest_s, cycle)
    return stops


def given(
    protocol: Protocol, values: Sequence[float], others: Mapping[str, Sequence[float]] = {}
) -> list[Stop]:
    """The stops of a protocol.

    Args:
        protocol: times, cycles and branches.
        values: values of its control.
        others: values of further controls, by name.
    """
    stops: list[Stop] = []
    for i, (time_s, value) in enumerate(zip(protocol.time_s, values, strict=True)):
        before = values[i - 1] if i else 0.0
        branch: Branch = "hold" if i and value == before else branch_of(before, value)
        if protocol.branch:
            branch = protocol.branch[i]
        further = {name: series[i] for name, series in others.items()}
        cycle = protocol.cycle[i] if protocol.cycle else 1
        stops.append(Stop(value, time_s, branch, cycle, further))
    return stops


def cycle_at(stops: Sequence[Stop]) -> Callable[[float], float]:
    """Return the number of the cycle as a function of the time (s).

    Between the last reading of one cycle and the first one of the next it grows in proportion, so
    that cycles may be left out.

    Args:
        stops: in order.
    """
    import numpy as np  # the command's help does without

    times, cycles = [stop.time_s for stop in stops], [float(stop.cycle) for stop in stops]
    return lambda time_s: float(np.interp(time_s, times, cycles))


LEAST = 0.1
"""Part of a step of the volume: a reading that is nearer than this is left out."""

FURTHER = 2.0
"""Factor by which a cavity can grow after a limit point with the ratio that is advised."""


def pressure_stops(config: Config) -> Sequence[Stop]:
    """Return the stops of the protocol, or steps from rest to the maximum and back.

    The value of a stop is a pressure (kPa). Under volume control it is the cavity's growth, as a
    part of its volume at rest, or of a protocol in ml.

    Args:
        config: of the experiment.

    Raises:
        ConfigError: one line, if the protocol is not one for a finger, or tells one time twice to
            a finger with inertia.
    """
    stops = _pressure_stops(config)
    for one, other in pairwise(stops) if config.experiment.dynamic else ():
        if other.time_s - one.time_s < EVEN_S:
            key = "protocol.time_s" if config.protocol.time_s else "experiment.hold_s: readings at"
            allowed = f"with experiment.dynamic each {EVEN_S:g} s or more after the one before"
            raise ConfigError(f"{key} = {one.time_s:g}, {other.time_s:g}: allowed: {allowed}")
    return stops


def _pressure_stops(config: Config) -> Sequence[Stop]:
    experiment, protocol = config.experiment, config.protocol
    if protocol.time_s:
        by = "volume" if protocol.volume_ml else "pressure"
        if experiment.control != by:
            raise ConfigError(
                f'experiment.control = "{experiment.control}": allowed: "{by}" with this protocol'
            )
        if protocol.volume_ml:
            return given(protocol, protocol.volume_ml, {})
        if not protocol.pressure_kPa:
            raise ConfigError("protocol.pressure_kPa = []: allowed: a pressure for each time_s")
        supplies = {supply_of(name).name: kPa for name, kPa in config.cavity.own.items()}
        return given(protocol, protocol.pressure_kPa, supplies)
    if not config.geometry.cavities():  # a solid body is at rest, or moves in a protocol's time
        return [Stop(0.0, 0.0, "hold")]
    if by_pressure(config):
        most, least = experiment.max_pressure_kPa, experiment.min_pressure_kPa
        values, suction = (steps(end, experiment.step_kPa) for end in (most, least))
        return cycles(values, experiment.rate_kPa_per_s, experiment, suction)
    return cycles(_growths(config), _growth_rate(config), experiment)


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
    return steps(experiment.max_volume_ratio - 1, experiment.step_volume_ratio)


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
    return [stop.value for stop in pressure_stops(config)] if by_pressure(config) else []


def closing_starts_s(config: Config) -> float:
    """Return the time (s) at which the food is in place and the fingers begin to close.

    Args:
        config: with suction, the fingers open, settle and approach before.
    """
    gripper = config.gripper
    if not config.experiment.min_pressure_kPa:
        return 0.0
    return gripper.pressurise_s + gripper.settle_s + gripper.approach_mm / gripper.lift_mm_per_s


def lift_starts_s(config: Config) -> float:
    """Return the time (s) at which the lift begins.

    Args:
        config: of the grasp.
    """
    return closing_starts_s(config) + config.gripper.pressurise_s + config.gripper.settle_s


EVEN_S: Final = 1e-9
"""Times that differ by less are one."""


class Lift(NamedTuple):
    """A lift that starts and ends at rest.

    Attributes:
        rate_mm_per_s2: acceleration of its first part, and deceleration of its last; 0: none.
        rising_s: time of each of both.
        length_s: time of the whole.
    """

    rate_mm_per_s2: float
    rising_s: float
    length_s: float

    @classmethod
    def of(cls, config: Config) -> Lift:
        """The lift of a configuration; a short one does not reach the configured speed."""
        gripper = config.gripper
        way_mm, speed = gripper.lift_mm, gripper.lift_mm_per_s
        if gripper.lift_acceleration_m_s2 is None:
            return cls(0.0, 0.0, way_mm / speed)
        rate = 1e3 * gripper.lift_acceleration_m_s2
        rising_s = min(speed / rate, (way_mm / rate) ** 0.5)
        return cls(rate, rising_s, rising_s + way_mm / (rate * rising_s))

    def part(self, time_s: float) -> float:
        """Return the part of the way after a time since its start."""
        time_s = min(max(time_s, 0.0), self.length_s)
        if not self.rising_s:
            return time_s / self.length_s
        left_s = self.length_s - time_s
        first, last = (max(self.rising_s - after_s, 0.0) for after_s in (time_s, left_s))
        total = self.rising_s * (self.length_s - self.rising_s)
        went = self.rising_s * (time_s - self.rising_s / 2) + first**2 / 2 - last**2 / 2
        return went / total

    def acceleration_mm_per_s2(self, time_s: float) -> float:
        """Return the gripper's acceleration upwards at a time since its start."""
        ends = (0.0, self.rising_s, self.length_s - self.rising_s, self.length_s)
        passed = sum(time_s > end_s + EVEN_S for end_s in ends)
        return self.rate_mm_per_s2 * (0, 1, 0, -1, 0)[passed]

    def stops_s(self, count: int) -> list[float]:
        """Return times of readings since its start: its phases' ends among ``count`` even ones."""
        even = [self.length_s * i / count for i in range(1, count + 1)]
        ends = [self.rising_s, self.length_s - self.rising_s] if self.rising_s else []
        return sorted({round(at_s, 9): at_s for at_s in (*ends, *even)}.values())


def table_z_mm(config: Config, time_s: float) -> float:
    """Return the height (mm) of the table seen from the gripper, 0 where the fingers close.

    Args:
        config: with the starts of approach and lift, their speed and their ways.
        time_s: time.
    """
    gripper = config.gripper
    left = (closing_starts_s(config) - time_s) * gripper.lift_mm_per_s
    way_mm = gripper.lift_mm * Lift.of(config).part(time_s - lift_starts_s(config))
    return 0.0 - min(max(left, 0.0), gripper.approach_mm) - way_mm


def grasp_stops(config: Config) -> Sequence[Stop]:
    """Stops of a grasp: steps to the highest pressure, a wait, the lift, a wait.

    With suction fingers open first, wait, and approach the food. The last wait has as many readings
    a second as the lift where fingers have inertia.

    Args:
        config: of the grasp.
    """
    gripper, experiment = config.gripper, config.experiment
    suction, largest = experiment.min_pressure_kPa, experiment.max_pressure_kPa
    count, lift = gripper.lift_readings, Lift.of(config)
    stops: list[Stop] = []

    def ramp(values: Sequence[float], start_s: float) -> None:
        ways = [abs(b - a) for a, b in pairwise(values)]
        for i, value in enumerate(values):
            part = sum(ways[:i]) / sum(ways)
            if i or not stops:  # the approach ends where the second ramp starts
                time_s = start_s + gripper.pressurise_s * part
                stops.append(Stop(value, time_s, branch_of(values[i - 1] if i else 0.0, value)))

    def move(value: float, start_s: float, lift: Lift, branch: GraspBranch) -> None:
        stops.append(Stop(value, start_s, "hold"))
        stops.extend(Stop(value, start_s + at_s, branch) for at_s in lift.stops_s(count))

    closing = steps(largest, experiment.step_kPa)
    if suction:
        opening = steps(suction, experiment.step_kPa)
        ramp(opening, 0.0)
        approach = Lift(0.0, 0.0, gripper.approach_mm / gripper.lift_mm_per_s)
        move(suction, gripper.pressurise_s + gripper.settle_s, approach, "approach")
        ramp([*opening[::-1], *closing[1:]], closing_starts_s(config))
    else:
        ramp(closing, 0.0)
    move(largest, lift_starts_s(config), lift, "lift")
    ends_s, rate = stops[-1].time_s, count / lift.length_s
    after = math.ceil(rate * gripper.settle_s) if experiment.dynamic else 1
    waited = [ends_s + gripper.settle_s * (i + 1) / after for i in range(after)]
    return [*stops, *(Stop(largest, wait_s, "hold") for wait_s in waited)]

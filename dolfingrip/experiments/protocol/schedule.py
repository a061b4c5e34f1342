"""The stops of an experiment: ramps, waits and cycles at given rates, or given times."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from dolfingrip.sections.protocol_file import waits

if TYPE_CHECKING:
    from dolfingrip.sections.procedure import Branch, ExperimentSettings, Protocol

    GraspBranch = Branch | Literal["approach", "lift"]


@dataclass(frozen=True, slots=True)
class Stop:
    """A point of the schedule at which readings are taken.

    Attributes:
        value: value of the control, in its unit.
        time_s: time since the first stop.
        branch: ``loading``, ``unloading``, ``hold``, or ``approach`` and ``lift`` of a grasp.
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
    found: list[Stop] = [Stop(values[0], 0.0, "loading")]

    def ramp(targets: Sequence[float], cycle: int) -> None:
        for value in targets:
            last = found[-1]
            time_s = last.time_s + abs(value - last.value) / rate
            branch: Branch = "loading" if value > last.value else "unloading"
            found.append(Stop(value, time_s, branch, cycle))

    def wait(length_s: float, cycle: int) -> None:
        last = found[-1]
        for after in waits(length_s, experiment.hold_readings):
            found.append(Stop(last.value, last.time_s + after, "hold", cycle))

    for cycle in range(1, experiment.cycles + 1):
        ramp(before[1:], cycle)
        ramp(before[-2::-1], cycle)
        ramp(values[1:], cycle)
        wait(experiment.hold_s, cycle)
        if experiment.unload or experiment.cycles > 1:
            ramp(values[-2::-1], cycle)
            wait(experiment.rest_s, cycle)
    return found


def given(
    protocol: Protocol, values: Sequence[float], others: Mapping[str, Sequence[float]] = {}
) -> list[Stop]:
    """The stops of a protocol.

    Args:
        protocol: times, cycles and branches.
        values: values of its control.
        others: values of further controls, by name.
    """
    found: list[Stop] = []
    for i, (time_s, value) in enumerate(zip(protocol.time_s, values, strict=True)):
        before = values[i - 1] if i else 0.0
        branch: Branch = "hold" if i and value == before else "loading"
        if value < before:
            branch = "unloading"
        if protocol.branch:
            branch = protocol.branch[i]
        further = {name: each[i] for name, each in others.items()}
        cycle = protocol.cycle[i] if protocol.cycle else 1
        found.append(Stop(value, time_s, branch, cycle, further))
    return found

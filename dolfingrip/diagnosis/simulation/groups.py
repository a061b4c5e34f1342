"""Which specimens share a simulation: those of the same set-up that went the same way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.columns import CONTROL
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.simulation import stops
from dolfingrip.diagnosis.simulation.schedule import StopSchedule
from dolfingrip.diagnosis.simulation.stops import ControlSegment


@dataclass(frozen=True, slots=True)
class SimulationGroup:
    """Tests that one simulation serves.

    Attributes:
        experiment: its name.
        config: the configuration with their set-up.
        tests: numbers of the tests.
        curve: one elastic curve, shared by all tests of this set-up, however they went; None where
            cavities have supplies of their own, as no single pressure tells the state then.
        in_time: the way these tests went.
        settled: the same without cycles that go as the one before them, which is read again.
    """

    experiment: str
    config: Config
    tests: tuple[int, ...]
    curve: StopSchedule | None
    in_time: StopSchedule
    settled: StopSchedule

    def schedule(self, config: Config) -> StopSchedule:
        """The stops that ``config``, this group's with other values, has to be simulated at."""
        if self.curve is not None and path_independent(config):
            return self.curve
        clock = any(effect.clock for effect in config.extensions.active())
        return self.in_time if clock else self.settled


def path_independent(config: Config) -> bool:
    """Tell whether readings depend on the control alone: no effect has a memory or a clock.

    Args:
        config: with its effects.
    """
    return not any(
        effect.kind == "dissipative" or effect.clock for effect in config.extensions.active()
    )


@dataclass(frozen=True, slots=True)
class _Led:
    """A test, the configuration with its set-up, and the way that it went."""

    test: SpecimenTest
    config: Config
    segments: list[ControlSegment]


def groups(
    measurement: Measurement, config: Config, headroom: float = 1.0
) -> list[SimulationGroup]:
    """The groups of a measurement's tests, in their order.

    Args:
        measurement: with the set-up of each test.
        config: that the set-ups differ from.
        headroom: pressure that elastic curves go on to, by the highest of the rows.
    """
    led = []
    for test in measurement.tests:
        segments = stops.segments(measurement.rows(test.number), test.controls, test.sigma)
        led.append(_Led(test, test.setup.applied(config), segments))
    found = []
    for of_setup in _together(led, _same_setup):
        test = of_setup[0].test
        control, more = CONTROL[test.experiment], headroom if test.of_finger else 1.0
        curve = None
        if not test.supplies:
            curve = stops.elastic([each.segments for each in of_setup], control, more)
        for part in _together(of_setup, lambda a, b: stops.alike(a.segments, b.segments)):
            tests = tuple(each.test.number for each in part)
            led_by = [each.segments for each in part]
            found.append(
                SimulationGroup(
                    part[0].test.experiment,
                    part[0].config,
                    tests,
                    curve and _of(curve, measurement, tests),
                    stops.in_time(led_by, control),
                    stops.in_time(led_by, control, settles=True),
                )
            )
    return found


def _same_setup(first: _Led, second: _Led) -> bool:
    one, other = first.test, second.test
    alike = one.experiment == other.experiment and set(one.supplies) == set(other.supplies)
    return alike and first.config == second.config


def _together(tests: Sequence[_Led], alike: Callable[[_Led, _Led], bool]) -> list[list[_Led]]:
    """Tests that are like the first of their part, in their order."""
    parts: list[list[_Led]] = []
    for test in tests:
        part = next((part for part in parts if alike(part[0], test)), None)
        if part is None:
            parts.append([test])
        else:
            part.append(test)
    return parts


def _of(route: StopSchedule, measurement: Measurement, tests: Sequence[int]) -> StopSchedule:
    """``route`` with the rows of these tests alone."""
    belongs = measurement.readings["test"].to_numpy()
    legs = []
    for leg in route.legs:
        mine = np.isin(belongs[leg.rows], tests)
        legs.append(replace(leg, rows=leg.rows[mine], rows_at=leg.rows_at[mine]))
    return replace(route, legs=tuple(legs))

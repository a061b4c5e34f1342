"""Which specimens share a simulation: those of the same set-up that went the same way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from dolfingrip.channels import PRESSURE
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import routes
from dolfingrip.diagnosis.simulation.legs import Route
from dolfingrip.diagnosis.simulation.routes import Segment


@dataclass(frozen=True, slots=True)
class SimulationGroup:
    """Tests that one simulation serves.

    Attributes:
        experiment: its name.
        config: the configuration with their set-up.
        tests: numbers of the tests.
        curve: one elastic curve, shared by all tests of this set-up, however they went.
        in_time: the way these tests went.
    """

    experiment: str
    config: Config
    tests: tuple[int, ...]
    curve: Route
    in_time: Route

    def route(self, config: Config) -> Route:
        """The stops that ``config``, this group's with other values, has to be simulated at."""
        if not path_independent(config):
            return self.in_time
        return self.curve


def path_independent(config: Config) -> bool:
    """Whether readings depend on the control alone: no effect has a memory or a clock."""
    return not any(
        effect.kind == "dissipative" or effect.clock for effect in config.extensions.active()
    )


def groups(
    measurement: Measurement, config: Config, headroom: float = 1.0
) -> list[SimulationGroup]:
    """The groups of a measurement's tests, in their order.

    Args:
        measurement: with the set-up of each test.
        config: that the set-ups differ from.
        headroom: pressure that elastic curves go on to, by the highest of the rows.
    """
    found: list[SimulationGroup] = []
    together: list[tuple[str, Config, list[tuple[int, list[Segment]]]]] = []
    for test in measurement.tests:
        sigma = test.setup.noise.get(test.control, 0.0)
        own = routes.segments(measurement.rows(test.number), test.control, sigma)
        applied = test.setup.applied(config)
        for experiment, other, members in together:
            if experiment == test.experiment and other == applied:
                members.append((test.number, own))
                break
        else:
            together.append((test.experiment, applied, [(test.number, own)]))
    for experiment, applied, members in together:
        control = measurement.tests[members[0][0]].control
        more = headroom if control == PRESSURE.name else 1.0
        for part in _alike(members):
            ways = [own for _, own in part]
            numbers = {number for number, _ in part}
            curve = _of(
                routes.elastic([own for _, own in members], control, more), measurement, numbers
            )
            found.append(
                SimulationGroup(
                    experiment,
                    applied,
                    tuple(sorted(numbers)),
                    curve,
                    routes.in_time(ways, control),
                )
            )
    return found


def _alike(
    members: Sequence[tuple[int, list[Segment]]],
) -> list[list[tuple[int, list[Segment]]]]:
    """Tests that went the same way, together."""
    parts: list[list[tuple[int, list[Segment]]]] = []
    for member in members:
        for part in parts:
            if routes.alike(part[0][1], member[1]):
                part.append(member)
                break
        else:
            parts.append([member])
    return parts


def _of(route: Route, measurement: Measurement, tests: set[int]) -> Route:
    """``route`` with the rows of these tests alone."""
    belongs = measurement.readings["test"].to_numpy()
    legs = []
    for leg in route.legs:
        mine = [belongs[row] in tests for row in leg.rows]
        legs.append(replace(leg, rows=leg.rows[mine], rows_at=leg.rows_at[mine]))
    return replace(route, legs=tuple(legs))

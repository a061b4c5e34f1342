"""All readings of a measurement, simulated, for each of several variants.

viscous = ModelVariant({"extensions.prony.g": [0.2]})
variants = [ModelVariant(), viscous, ModelVariant(gradients=("material.mu_MPa",))]
base, prony, slopes = simulate(measurement, config, variants, Workers(folder, Where(workers=2)))
prony.readings - base.readings     # (n,), aligned with measurement.listed
slopes.slopes["material.mu_MPa"]   # (n,)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from dolfingrip import parameter
from dolfingrip.channels import FORCE
from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.data.clock import moves
from dolfingrip.diagnosis.data.measurement import Measurement, Rows, SpecimenTest
from dolfingrip.diagnosis.simulation import stops
from dolfingrip.diagnosis.simulation.runner import Workers, request
from dolfingrip.diagnosis.simulation.stops import StopSchedule
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.extensions.effect import Stage
from dolfingrip.extensions.index import effect
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.protocol_file import key as key_of
from dolfingrip.sections.section import Section


@dataclass(frozen=True, slots=True)
class SimulationGroup:
    """Tests that one simulation serves.

    Attributes:
        experiment: its name.
        config: the configuration with their set-up.
        tests: numbers of the tests.
        curve: one elastic curve, shared by all tests of this set-up, however they went, with the
            rows of all of them; None where cavities have supplies of their own, as no single
            pressure tells the state then, and where time tells it: with inertia, or a supply of
            air.
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

    def feels(self, key: str) -> bool:
        """Tell whether its readings can feel a key of the configuration, as far as effects go."""
        section, _, name = key.partition(".")
        if section != "extensions":
            return True
        kind = effect(name.partition(".")[0])
        if kind.by_decades and max(self.in_time.cycle) < 10:
            return False
        felt = kind.felt_on(EXPERIMENTS[self.experiment].parts) and supplied(
            kind, self.config.experiment.control
        )
        return felt and (self.experiment != "bending" or kind.felt_in_bending(self.config))


def path_independent(config: Config) -> bool:
    """Tell whether readings depend on the control alone: no effect has a memory or a clock.

    Args:
        config: with its effects.
    """
    return not any(effect.follows_path() for effect in config.extensions.active())


def still(config: Config, follows: bool) -> Config:
    """Return ``config`` as an experiment is simulated that may not follow motion.

    Args:
        config: with its set-up.
        follows: whether it does.
    """
    if follows or not config.experiment.dynamic:
        return config
    held, moves = {"held_x_mm": None, "load_x_N": 0.0}, {"time_s": (), "acceleration_m_s2": ()}
    return config.changed(experiment={"dynamic": False}, release=held, base=moves)


def groups(measurement: Measurement, config: Config) -> list[SimulationGroup]:
    """The groups of a measurement's tests, in their order.

    Args:
        measurement: with the set-up of each test.
        config: that the set-ups differ from.
    """
    applied = [
        still(one, EXPERIMENTS[test.experiment].dynamic)
        for test, one in zip(measurement.tests, measurement.applied(config), strict=True)
    ]
    ways = [
        stops.segments(measurement.rows(test.number), test.controls, test.sigma, measurement.policy)
        for test in measurement.tests
    ]

    def same_setup(one: SpecimenTest, other: SpecimenTest) -> bool:
        alike = one.experiment == other.experiment and set(one.supplies) == set(other.supplies)
        return alike and applied[one.number] == applied[other.number]

    def same_way(one: SpecimenTest, other: SpecimenTest) -> bool:
        return stops.alike(ways[one.number], ways[other.number])

    parts = []
    for of_setup in _together(measurement.tests, same_setup):
        first = of_setup[0]
        control = first.prescribed
        curve, moving = None, moves(applied[first.number])
        if not (first.supplies or moving):
            curve = stops.elastic([ways[test.number] for test in of_setup], control)
        for part in _together(of_setup, same_way):
            tests = tuple(test.number for test in part)
            led = [ways[number] for number in tests]
            at_rows = stops.moment_by_moment(led, control) if moving else None
            parts.append(
                SimulationGroup(
                    first.experiment,
                    applied[tests[0]],
                    tests,
                    curve,
                    at_rows or stops.in_time(led, control),
                    at_rows or stops.in_time(led, control, settles=True),
                )
            )
    return parts


def _together(
    tests: Sequence[SpecimenTest], alike: Callable[[SpecimenTest, SpecimenTest], bool]
) -> list[list[SpecimenTest]]:
    """Tests that are like the first of their part, in their order."""
    parts: list[list[SpecimenTest]] = []
    for test in tests:
        part = next((part for part in parts if alike(part[0], test)), None)
        if part is None:
            parts.append([test])
        else:
            part.append(test)
    return parts


@dataclass(frozen=True, slots=True)
class ModelVariant:
    """The changes of one simulation of all tests.

    Attributes:
        overrides: values by key, which take precedence over the set-up of each test; effects that
            an experiment does not feel are left out there.
        gradients: keys of parameters that readings are derived by; those that an experiment does
            not have are left out there.
        mesh_check: whether the error of the mesh is estimated.
    """

    overrides: Change = field(default_factory=dict)
    gradients: tuple[str, ...] = ()
    mesh_check: bool = False

    def of(self, group: SimulationGroup) -> Config:
        """The configuration that a group is simulated with, without its protocol."""
        felt = {key: value for key, value in self.overrides.items() if group.feels(key)}
        return changed(group.config, felt)


@dataclass(frozen=True, slots=True)
class SimulatedGroup:
    """One simulation that was run, and the tests that it serves.

    Attributes:
        group: the tests.
        config: of the simulation.
        schedule: its stops.
        result: readings at the stops.
    """

    group: SimulationGroup
    config: Config
    schedule: StopSchedule
    result: Answer

    @property
    def why(self) -> str:
        """Sentence on why it ended where it did."""
        return self.result.failure or ""

    def change(self, amounts: Mapping[str, float]) -> Mapping[str, np.ndarray]:
        """Change (reached,) of the readings by column, by derivatives.

        Args:
            amounts: that parameters change by; those that nothing is derived by change nothing.
        """
        change = {name: np.zeros(len(values)) for name, values in self.result.columns.items()}
        for (name, key), slope in self.result.slopes.items():
            change[name] += amounts.get(key, 0.0) * np.nan_to_num(slope)
        return change

    def force(self, name: str) -> np.ndarray | None:
        """Force (reached,) that begins to act where a finger touches; None of other readings.

        Args:
            name: of the column that is read.
        """
        touching = "plate" in EXPERIMENTS[self.group.experiment].parts and name == FORCE.name
        return self.result.columns[name] if touching else None


@dataclass(frozen=True, eq=False)
class SimulatedReadings:
    """The readings of a measurement as a model has them.

    Attributes:
        readings: (n,) in the unit of each column; NaN where a simulation did not come so far.
        by_control: (n,) derivative of the reading by the control, for each kPa or mm; 0 in waits of
            models with memory.
        measurement: the readings that were measured.
        runs: all simulations; none where they are a closed form.
    """

    readings: np.ndarray
    by_control: np.ndarray
    measurement: Measurement
    runs: Sequence[SimulatedGroup] = ()

    @classmethod
    def of(cls, measurement: Measurement, runs: Sequence[SimulatedGroup]) -> SimulatedReadings:
        """Read simulations at the measured rows."""
        at_rows = partial(_at_rows, measurement, runs, lambda run: run.result.columns)
        readings, by_control = (measurement.collected(at_rows(derivative=d)) for d in (0, 1))
        return cls(readings, by_control, measurement, runs)

    @property
    def true(self) -> Rows:
        """Readings at all rows, which instruments are to show."""
        return _at_rows(self.measurement, self.runs, lambda run: run.result.columns)

    def changes(self, amounts: Callable[[Config], Mapping[str, float]]) -> Rows:
        """Return changes of the readings at all rows, by derivatives.

        Args:
            amounts: that parameters change by, in a configuration.
        """
        return _at_rows(self.measurement, self.runs, lambda run: run.change(amounts(run.config)))

    def by(self, key: str) -> Rows:
        """Derivatives of the readings at all rows by a parameter."""
        return self.changes(lambda _: {key: 1.0})

    @cached_property
    def slopes(self) -> Mapping[str, np.ndarray]:
        """Derivative (n,) by each parameter that is felt, for each unit of it.

        Entries of a list are numbered, as in ``extensions.prony.g[0]``.
        """
        keys = dict.fromkeys(key for run in self.runs for _, key in run.result.slopes)
        return {key: self.measurement.collected(self.by(key), 0.0) for key in keys}

    @property
    def failures(self) -> Sequence[SimulatedGroup]:
        """Simulations that left readings without a number."""
        test, lost = self.measurement.listed["test"], np.isnan(self.readings)
        ended = (run for run in self.runs if run.result.failure_class is not None)
        return [run for run in ended if lost[test.isin(run.group.tests)].any()]


def _at_rows(
    measurement: Measurement,
    runs: Sequence[SimulatedGroup],
    values: Callable[[SimulatedGroup], Mapping[str, np.ndarray]],
    derivative: int = 0,
) -> Rows:
    """Readings at all rows from (reached,) values by column at the stops of each simulation."""
    count = len(measurement.readings)
    return {
        run.group.tests: {
            name: run.schedule.at_rows(at_stops, count, derivative, run.force(name))
            for name, at_stops in values(run).items()
        }
        for run in runs
    }


def simulate(
    measurement: Measurement, config: Config, variants: Sequence[ModelVariant], workers: Workers
) -> list[SimulatedReadings]:
    """Simulate all tests of ``measurement`` for each of ``variants``.

    Args:
        measurement: whose protocols are followed.
        config: that set-ups and variants differ from.
        variants: what is changed; those that come to the same simulation share it.
        workers: where simulations are computed and kept.

    Raises:
        ConfigError: one line, where a variant is not allowed or there are no workers.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    parts = groups(measurement, config)
    planned = [
        [_planned(variant, group, measurement.read_by(group.experiment)) for group in parts]
        for variant in variants
    ]
    results = iter(workers.results([request for row in planned for *_, request in row]))
    simulated = []
    for row in planned:
        runs = [SimulatedGroup(group, cfg, route, next(results)) for group, cfg, route, _ in row]
        simulated.append(SimulatedReadings.of(measurement, runs))
    return simulated


def _planned(
    variant: ModelVariant, group: SimulationGroup, read: Sequence[str]
) -> tuple[SimulationGroup, Config, StopSchedule, Request]:
    config = variant.of(group)
    route = group.schedule(config)
    # the gradients' keys of effects at their neutral values do not make the readings others
    wanted = request(
        group.experiment,
        changed(config, {key_of(name): values for name, values in route.protocol().items()}),
        tuple(key for key in variant.gradients if _feels(group.experiment, config, key)),
        mesh_check=variant.mesh_check,
        read=read,
    )
    return group, config, route, wanted


def supplied(section: type[Section], control: str) -> bool:
    """Return whether a section acts: where a volume is prescribed, no stage of a supply does.

    Args:
        section: an effect or another table.
        control: what is prescribed, as ``experiment.control`` tells it.
    """
    return control == "pressure" or not issubclass(section, Stage)


def _feels(experiment: str, config: Config, key: str) -> bool:
    """Return whether an experiment's readings can depend on a parameter."""
    return any(
        p.section.felt_on(EXPERIMENTS[experiment].parts)
        for p in parameter.every(config)
        if supplied(p.section, config.experiment.control)
        if p.key == key or p.key.startswith(f"{key}[")
        if config.mesh.file is None or not issubclass(p.section, Geometry)
    )

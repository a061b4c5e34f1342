"""All readings of a measurement, simulated, for each of several variants.

viscous = ModelVariant({"extensions.prony.g": [0.2]})
variants = [ModelVariant(), viscous, ModelVariant(gradients=("material.mu_MPa",))]
base, prony, slopes = simulate(measurement, config, variants, Workers(folder, Where(workers=2)))
prony.readings - base.readings     # (n,), aligned with measurement.listed()
slopes.slope("material.mu_MPa")    # (n,)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.simulation.groups import SimulationGroup, groups
from dolfingrip.diagnosis.simulation.runner import Workers, request
from dolfingrip.diagnosis.simulation.schedule import StopSchedule
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.parameter import every
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.protocol_file import key as key_of


@dataclass(frozen=True, slots=True)
class ModelVariant:
    """The changes of one simulation of all tests.

    Attributes:
        overrides: values by key, which take precedence over the set-up of each test.
        gradients: keys of parameters that readings are derived by; those that an experiment does
            not have are left out there.
        headroom: pressure to go on to where the model has no memory, by the highest of the rows,
            for :mod:`dolfingrip.diagnosis.simulation.variants`.
        only_in: experiments that ``overrides`` are for; all where None.
        elsewhere: overrides for the other experiments.
        derived_elsewhere: whether these are derived by ``gradients``, too.
        mesh_check: whether the error of the mesh is estimated.
        tilt_deg: turn of gravity in the plane of bending, towards the bellows for a finger that
            hangs, from the direction that each test has.
    """

    overrides: Change = field(default_factory=dict)
    gradients: tuple[str, ...] = ()
    headroom: float = 1.0
    only_in: frozenset[str] | None = None
    elsewhere: Change = field(default_factory=dict)
    tilt_deg: float = 0.0
    derived_elsewhere: bool = True
    mesh_check: bool = False

    def of(self, group: SimulationGroup) -> Config:
        """The configuration that a group is simulated with, without its protocol."""
        felt = self.only_in is None or group.experiment in self.only_in
        config = changed(group.config, self.overrides if felt else self.elsewhere)
        if not (felt and self.tilt_deg and config.gravity.acceleration_m_s2):
            return config
        x, y, z = config.gravity.direction
        cos, sin = math.cos(math.radians(self.tilt_deg)), math.sin(math.radians(self.tilt_deg))
        return config.changed(gravity={"direction": [cos * x + sin * z, y, cos * z - sin * x]})


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


@dataclass(frozen=True, slots=True)
class SimulationFailure:
    """A simulation that did not come to its end.

    Attributes:
        tests: that it was for.
        sentence: why, for people.
    """

    tests: tuple[SpecimenTest, ...]
    sentence: str


@dataclass(slots=True)
class SimulatedReadings:
    """The readings of a measurement as one variant has them.

    Attributes:
        variant: what was simulated.
        readings: (n,) in the unit of each column; NaN where a simulation did not come so far.
        by_control: (n,) derivative of the reading by the control, for each kPa or mm; 0 in waits of
            models with memory.
        slopes: (n,) derivative by each parameter that is felt, for each unit of it; entries of a
            list are numbered, as in ``extensions.prony.g[0]``.
        failures: of simulations that left readings without a number.
        runs: the simulations themselves.
    """

    variant: ModelVariant
    readings: np.ndarray
    by_control: np.ndarray
    slopes: Mapping[str, np.ndarray]
    failures: Sequence[SimulationFailure]
    runs: Sequence[SimulatedGroup]

    def slope(self, key: str) -> np.ndarray:
        """(n,) derivative by a parameter, for each unit of it; 0 where nothing feels it.

        Raises:
            KeyError: it was not asked for, or it is a list, whose entries are meant.
        """
        if key in self.slopes:
            return self.slopes[key]
        entries = [name for name in self.slopes if name.startswith(f"{key}[")]
        if entries or key not in self.variant.gradients:
            raise KeyError(f"{key}; there are {', '.join(entries or self.slopes)}")
        return np.zeros_like(self.readings)


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
    parts = {h: groups(measurement, config, h) for h in {variant.headroom for variant in variants}}
    planned = [
        [_planned(variant, group, measurement.columns) for group in parts[variant.headroom]]
        for variant in variants
    ]
    results = iter(workers.results([asked for row in planned for *_, asked in row]))
    found = []
    for variant, row in zip(variants, planned, strict=True):
        runs = [SimulatedGroup(group, own, route, next(results)) for group, own, route, _ in row]
        found.append(_assembled(measurement, variant, runs))
    return found


def _planned(
    variant: ModelVariant, group: SimulationGroup, seen: Sequence[str]
) -> tuple[SimulationGroup, Config, StopSchedule, Request]:
    config = variant.of(group)
    route = group.schedule(config)
    felt = (
        variant.derived_elsewhere or variant.only_in is None or group.experiment in variant.only_in
    )
    gradients = variant.gradients if felt else ()
    # the gradients' keys of effects at their neutral values do not make the readings others
    asked = request(
        group.experiment,
        changed(config, {key_of(name): values for name, values in route.protocol().items()}),
        tuple(each for each in gradients if _feels(group.experiment, config, each)),
        mesh_check=variant.mesh_check,
        seen=seen,
    )
    return group, config, route, asked


def _feels(experiment: str, config: Config, key: str) -> bool:
    """Return whether an experiment's readings can depend on a parameter."""
    return any(
        each.section.felt_on(EXPERIMENTS[experiment].parts)
        for each in every(config)
        if each.key == key or each.key.startswith(f"{key}[")
        if config.mesh.file is None or not issubclass(each.section, Geometry)
    )


def _assembled(
    measurement: Measurement, variant: ModelVariant, runs: Sequence[SimulatedGroup]
) -> SimulatedReadings:
    listed = measurement.listed()
    count = len(measurement.readings)
    row = listed["row"].to_numpy()
    readings = np.full(len(listed), np.nan)
    by_control = np.full(len(listed), np.nan)
    slopes: dict[str, np.ndarray] = {}
    failures: list[SimulationFailure] = []
    for run in runs:
        for name, at in measurement.places(run.group.tests).items():
            values = run.result.columns.get(name, np.empty(0))
            readings[at] = run.schedule.at_rows(values, count)[row[at]]
            by_control[at] = run.schedule.slopes(values, count)[row[at]]
            for (read, key), slope in run.result.slopes.items():
                if read == name:
                    own = slopes.setdefault(key, np.zeros(len(listed)))
                    own[at] = run.schedule.at_rows(slope, count)[row[at]]
        lost = np.isnan(readings[listed["test"].isin(run.group.tests)]).any()
        if run.result.failure_class is not None and lost:
            tests = tuple(measurement.tests[number] for number in run.group.tests)
            failures.append(SimulationFailure(tests, run.result.failure or ""))
    return SimulatedReadings(variant, readings, by_control, slopes, failures, runs)

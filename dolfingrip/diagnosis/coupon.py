"""Coupons: their readings in closed form, and derivatives by differences.

Grips that slide let a coupon stretch evenly. A simulation is then a closed form:
:mod:`dolfingrip.experiments.rigs.uniaxial`. Moduli scale it exactly.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import ClassVar, Final

import numpy as np

from dolfingrip.channels import FORCE, TIME, TRANSVERSE_STRAIN
from dolfingrip.config import NO_CHANGE, Change, Config, changed
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.problem import Subset
from dolfingrip.diagnosis.core.unknown import Cause, Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion, joined
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings, SimulationGroup, groups
from dolfingrip.experiments.rigs.uniaxial import Stretching, UniaxialTension
from dolfingrip.extensions.effect import Energetic
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import named

STEP: Final = 0.01
"""Of ζ, by which simulations of coupons are differentiated."""


def in_closed_form(measurement: Measurement, config: Config) -> bool:
    """Tell whether all tests are coupons that stretch evenly, and forces and widths are read.

    Args:
        measurement: the tests.
        config: the model that is diagnosed.
    """
    applied = measurement.applied(config)
    columns = {FORCE.name, TRANSVERSE_STRAIN.name}
    return set(measurement.listed["column"]) <= columns and all(
        test.experiment == "coupon"
        and one.coupon.grip != "clamped"
        and not any(effect.shears_bars for effect in one.extensions.active())
        for test, one in zip(measurement.tests, applied, strict=True)
    )


Solved = Sequence[tuple[SimulationGroup, Mapping[str, np.ndarray]]]
"""Readings at each group's stops, (places, stops) by column."""


class CouponSimulation:
    """Simulates the coupons of a measurement.

    Args:
        measurement: of coupons alone.
        config: the model that is diagnosed.
    """

    closed_form: ClassVar = True
    at_once: int = 1000
    not_reached: Sequence[str] = ()

    def __init__(self, measurement: Measurement, config: Config) -> None:
        self.measurement = measurement
        self.config = config
        self.groups: Sequence[SimulationGroup] = groups(measurement, config)
        self.mesh = np.zeros(len(measurement.listed))

    @cached_property
    def _plain(self) -> Solved:
        """Readings of the model as configured."""
        return self._solved({}, {})

    @cached_property
    def base(self) -> SimulatedReadings:
        """The model as configured."""
        shown = self._displayed({}, self._plain)[0]
        return SimulatedReadings(shown, self._read(self._plain, derivative=1)[0], self.measurement)

    @property
    def configured(self) -> np.ndarray:
        return self.base.readings

    @cached_property
    def rig(self) -> Sequence[Nuisance]:
        """Numbers that the laboratory told a deviation of by their key."""
        numbers = []
        for key, std in self.measurement.tests[0].setup.nuisances.items():
            if "." in key and std:
                off = {key: std}
                moved = self._displayed({}, self._solved({}, {}, off), off)[0]
                there = named(key).value(_changed(self.groups[0].config, {}, {key: 0.0}))
                number = Unknown.marginal(key, std, named(key).unit, there)
                numbers.append(Nuisance(number, moved - self.base.readings))
        return numbers

    def plain(self, point: Point) -> Tangents:
        """Simulate the model without causes."""
        (run,) = self.tangents([], np.zeros((1, 0)), [point])
        return run

    def resting(self, causes: Sequence[Cause], start: Point) -> None:
        """Return nothing: causes are simulated all over their priors, at no cost."""

    def additions(
        self, points: Sequence[Point], measurements: Sequence[Measurement], *, known_mesh: bool
    ) -> list[tuple[list[Tangents | None], Sequence[Nuisance]]]:
        """Simulate other coupons, all at once; these have no mesh, and each is clamped anew."""
        together = joined(*measurements)
        tangents = CouponSimulation(together, self.config)._tangents(points)
        tests, first = together.listed["test"].to_numpy(), 0
        answers: list[tuple[list[Tangents | None], Sequence[Nuisance]]] = []
        for measurement in measurements:
            last = first + measurement.listed["test"].nunique()
            rows = (tests >= first) & (tests < last)
            answers.append(([_reached(run.rows(rows)) for run in tangents], ()))
            first = last
        return answers

    def at(self, points: Sequence[Point]) -> list[Tangents | None]:
        """Simulate other numbers, those of the same causes together; None without equilibrium."""
        return [_reached(run) for run in self._tangents(points)]

    def _tangents(self, points: Sequence[Point]) -> list[Tangents]:
        """Simulate other numbers; NaN without equilibrium."""
        together = defaultdict[Subset, list[int]](list)
        for place, point in enumerate(points):
            together[tuple(cause.name for cause, _ in point.causes)].append(place)
        runs: dict[int, Tangents] = {}
        for alike in together.values():
            causes = [cause for cause, _ in points[alike[0]].causes]
            zeta = np.array([[z for _, z in points[place].numbers] for place in alike])
            tangents = self.tangents(causes, zeta, [points[place] for place in alike])
            runs |= zip(alike, tangents, strict=True)
        return [runs[place] for place in range(len(points))]

    def tangents(
        self, causes: Sequence[Cause], zeta: np.ndarray, points: Sequence[Point]
    ) -> list[Tangents]:
        """Simulate several numbers of the same causes, all at once; NaN without equilibrium.

        Args:
            causes: that act.
            zeta: of their numbers, shape (places, d).
            points: these with the moduli, places of them.
        """
        count, d = zeta.shape
        box = np.vstack([np.zeros((0, 2)), *(cause.box() for cause in causes)])
        step = np.where(zeta + STEP > box[:, 1], -STEP, STEP)
        moved = np.concatenate([np.zeros((count, 1, d)), step[:, :, None] * np.eye(d)], axis=1)
        every = (zeta[:, None] + moved).reshape(count * (1 + d), d)
        readings = self._readings(causes, every).reshape(count, 1 + d, -1)
        by = (readings[:, 1:] - readings[:, :1]) / step[:, :, None]
        scaled, tangents = in_proportion(self.measurement), []
        for point, (value, *_), slopes in zip(points, readings, by, strict=True):
            c = np.where(scaled, point.moduli, 1.0)
            numbers = [n.coordinate(np.array(z))[1] for n, z in point.numbers]
            by_u = slopes / np.array(numbers).reshape(-1, 1)
            by_c = point.factor.coordinate_of(point.moduli)[1] * np.where(scaled, value, 0.0)
            columns = np.column_stack([c * value, by_c, *(c * slope for slope in by_u)])
            tangents.append(Tangents(point.u, columns[None]))
        return tangents

    def _readings(self, causes: Sequence[Cause], zeta: np.ndarray) -> np.ndarray:
        """Readings (places, n) with some effects; NaN without equilibrium.

        Args:
            causes: effects that are not on.
            zeta: their numbers, shape (places, d).
        """
        values: Change = {}
        numbers = [number for cause in causes for number in cause.numbers]
        for cause in causes:
            for number, value in cause.held:
                values = {**values, **number.change(value)}
        for i, number in enumerate(numbers):
            at = number.at(zeta[:, [i]] if number.listed else zeta[:, i])
            values = {**values, number.key: at}
        return self._many(values, len(zeta))

    def _many(self, values: Change, count: int) -> np.ndarray:
        """Readings (places, n) at values by key; arrays hold one for each place, (places, …)."""
        along = {key: array for key, array in values.items() if isinstance(array, np.ndarray)}
        material = {
            key for key in values
            if not key.startswith("extensions.") or issubclass(effect(key.split(".")[1]), Energetic)
        }  # fmt: skip
        every = [
            {**values, **{key: array[place].tolist() for key, array in along.items()}}
            for place in range(1 if material >= along.keys() else count)
        ]
        parameters = {key: array for key, array in along.items() if key in material}
        solved = self._solved(every[0], parameters) if material else self._plain
        if len(every) < count:
            return self._displayed(every[0], solved)
        shown = []
        for place, one in enumerate(every):
            rows = [
                (group, {name: _row(values, place) for name, values in columns.items()})
                for group, columns in solved
            ]
            shown.append(self._displayed(one, rows)[0])
        return np.vstack(shown)

    def _solved(
        self,
        overrides: Change,
        parameters: Mapping[str, np.ndarray],
        moved: Mapping[str, float] = NO_CHANGE,
    ) -> Solved:
        """True readings at each group's stops, (places, stops) by column."""
        configs = [_changed(group.config, overrides, moved).adapted() for group in self.groups]
        of_material = defaultdict[int, list[int]](list)
        for place, config in enumerate(configs):
            first = (i for i in of_material if _of_one_material(configs[i], config))
            of_material[next(first, place)].append(place)
        readings: dict[int, Mapping[str, np.ndarray]] = {}
        for first_place, alike in of_material.items():
            protocols = []
            for place in alike:
                coupon, route = configs[place].coupon, self.groups[place].in_time
                strain = [value / coupon.gauge_length_mm for value in route.value]
                protocols.append(Stretching(strain, route.time_s, coupon.step_strain, route.cycle))
            bars = UniaxialTension(configs[first_place]).follow(parameters, protocols)
            for place, bar in zip(alike, bars, strict=True):
                force_N = bar.stress_MPa * configs[place].coupon.area_mm2
                readings[place] = {FORCE.name: force_N, TRANSVERSE_STRAIN.name: bar.across - 1}
        return [(group, readings[place]) for place, group in enumerate(self.groups)]

    def _displayed(
        self, overrides: Change, solved: Solved, moved: Mapping[str, float] = NO_CHANGE
    ) -> np.ndarray:
        """Readings (places, n) as instruments show them."""
        shown = [
            (group, _changed(group.config, overrides, moved).extensions.displayed(
                {**values, TIME.name: np.array(group.in_time.time_s)}))
            for group, values in solved
        ]  # fmt: skip
        return self._read(shown)

    def _read(self, solved: Solved, derivative: int = 0) -> np.ndarray:
        """Readings (places, n), or their derivatives by the travel."""
        count = len(self.measurement.readings)
        return self.measurement.collected({
            group.tests: {
                name: group.in_time.at_rows(columns[name], count, derivative)
                for name in (FORCE.name, TRANSVERSE_STRAIN.name)
            }
            for group, columns in solved
        })  # fmt: skip


def _changed(config: Config, overrides: Change, moved: Mapping[str, float]) -> Config:
    """A configuration with other values, and with numbers moved from theirs.

    Those of an effect that is off move from where it does nothing.
    """
    there = changed(config, overrides)
    for key in moved:
        section, _, number = key.partition(".")
        name = number.partition(".")[0]
        if section == "extensions" and name not in there.extensions.inner:
            there = changed(there, {f"{section}.{name}": dict(effect(name).neutral)})
    return changed(there, {key: named(key).value(there) + by for key, by in moved.items()})


def _reached(run: Tangents) -> Tangents | None:
    return run if np.isfinite(run.told).all() else None


def _of_one_material(one: Config, other: Config) -> bool:
    """Tell whether configurations differ by their coupons' sizes and motions alone."""
    return one.model_copy(update={"coupon": other.coupon}) == other


def _row(values: np.ndarray, place: int) -> np.ndarray:
    """One place's readings; all places' where they are the same for all."""
    return values[place : place + 1] if len(values) > 1 else values

"""Readings of coupons in closed form, for many sets of an effect's numbers at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dolfingrip.channels import FORCE, TIME, TRANSVERSE_STRAIN
from dolfingrip.config import NO_CHANGE, Change, Config, changed
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.groups import SimulationGroup, groups
from dolfingrip.experiments.rigs.uniaxial import UniaxialTension
from dolfingrip.extensions.effect import Energetic
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import named


def in_closed_form(measurement: Measurement, config: Config) -> bool:
    """Tell whether all tests are coupons that stretch evenly, and forces and widths are read.

    Args:
        measurement: the tests.
        config: the model that is diagnosed.
    """
    applied = [test.setup.applied(config) for test in measurement.tests]
    known = {FORCE.name, TRANSVERSE_STRAIN.name}
    return set(measurement.listed()["column"]) <= known and all(
        test.experiment == "coupon" and own.coupon.grip != "clamped" and not _sheared(own)
        for test, own in zip(measurement.tests, applied, strict=True)
    )


def _sheared(config: Config) -> bool:
    raster = getattr(config.extensions, "print_anisotropy")  # noqa: B009
    return raster is not None and bool(raster.raster_deg)


class CouponSimulation:
    """Simulates the coupons of a measurement.

    Args:
        measurement: of coupons alone.
        config: the model that is diagnosed.
    """

    def __init__(self, measurement: Measurement, config: Config) -> None:
        self.measurement = measurement
        self.config = config
        self.groups: Sequence[SimulationGroup] = groups(measurement, config)
        self._true: dict[int, dict[str, np.ndarray]] = {}

    def base(
        self, overrides: Change = NO_CHANGE, *, moved: Mapping[str, float] | None = None
    ) -> np.ndarray:
        """(n,) readings as configured, with these overrides.

        Args:
            overrides: values by key.
            moved: by how much numbers differ from those of each test's set-up, by key.
        """
        solved = self._solved(overrides, {}, moved or {})
        return self._displayed(overrides, solved)[0]

    def slopes(self) -> np.ndarray:
        """(n,) derivative of the readings by the travel, for each mm."""
        solved = self._solved({}, {})
        count = len(self.measurement.readings)
        return self.measurement.collected(
            {
                group.tests: {
                    name: group.in_time.slopes(own[0], count) for name, own in values.items()
                }
                for group, values in solved
            }
        )

    def changed(self, causes: Sequence[Cause], zeta: np.ndarray) -> np.ndarray:
        """(places, n) changes of the readings by causes that act together.

        Args:
            causes: effects that are not on.
            zeta: their numbers one after the other, shape (places, d).

        Returns:
            NaN in places without an equilibrium.
        """
        numbers = [number for cause in causes for number in cause.numbers]
        told = {number.key: number.at(zeta[:, i]) for i, number in enumerate(numbers)}
        shaped = {
            number.key: told[number.key][:, None] if number.listed else told[number.key]
            for number in numbers
        }
        energies = [cause for cause in causes if issubclass(effect(cause.name), Energetic)]
        on = self._overrides(causes, zeta[0])
        ours = {number.key for cause in energies for number in cause.numbers}
        parameters = {key: values for key, values in shaped.items() if key in ours}
        solved = self._solved(on if energies else {}, parameters)
        if len(energies) == len(causes):
            return self._displayed(on, solved) - self.base()
        shown = []
        for place, z in enumerate(zeta):
            own = [
                (group, {name: _row(values, place) for name, values in columns.items()})
                for group, columns in solved
            ]
            shown.append(self._displayed(self._overrides(causes, z), own)[0])
        return np.vstack(shown) - self.base()

    @staticmethod
    def _overrides(causes: Sequence[Cause], zeta: np.ndarray) -> Change:
        found: dict[str, Any] = {}
        at = 0
        for cause in causes:
            d = len(cause.numbers)
            found |= cause.overrides(zeta[at : at + d])
            at += d
        return found

    def _solved(
        self,
        overrides: Change,
        parameters: Mapping[str, np.ndarray],
        moved: Mapping[str, float] = NO_CHANGE,
    ) -> list[tuple[SimulationGroup, dict[str, np.ndarray]]]:
        """True readings at each group's stops, (places, stops) by column."""
        found = []
        for number, group in enumerate(self.groups):
            as_it_is = not overrides and not moved
            if as_it_is and number in self._true:
                found.append((group, self._true[number]))
                continue
            config = changed(group.config, overrides)
            places = {key: named(key).value(config) + by for key, by in moved.items()}
            config = changed(config, places).adapted()
            coupon, route = config.coupon, group.in_time
            gauge = coupon.gauge_length_mm
            pulled = UniaxialTension(config).pull(
                parameters, [value / gauge for value in route.value], route.time_s,
                coupon.step_strain,
            )  # fmt: skip
            values = {
                FORCE.name: pulled.stress_MPa * coupon.area_mm2,
                TRANSVERSE_STRAIN.name: np.where(
                    np.isfinite(pulled.stress_MPa), pulled.across - 1, np.nan
                ),
            }
            if as_it_is:
                self._true[number] = values
            found.append((group, values))
        return found

    def _displayed(
        self, overrides: Change, solved: Sequence[tuple[SimulationGroup, dict[str, np.ndarray]]]
    ) -> np.ndarray:
        """(places, n) what the instruments show."""
        places = max(len(next(iter(values.values()))) for _, values in solved)
        shown = [
            (group, changed(group.config, overrides).extensions.displayed(
                {**values, TIME.name: np.array(group.in_time.time_s)}))
            for group, values in solved
        ]  # fmt: skip
        count = len(self.measurement.readings)
        return np.array([
            self.measurement.collected({
                group.tests: {
                    name: group.in_time.at_rows(columns[name][place], count)
                    for name in (FORCE.name, TRANSVERSE_STRAIN.name)
                }
                for group, columns in shown
            })
            for place in range(places)
        ])  # fmt: skip


def _row(values: np.ndarray, place: int) -> np.ndarray:
    """One place's readings; all places' where they are the same for all."""
    return values[place : place + 1] if len(values) > 1 else values

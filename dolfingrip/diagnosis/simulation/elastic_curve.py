"""Readings that follow from the elastic curve at another load: no simulation is needed.

A finger without memory, friction and clock turns and presses as the pressure in its cavity tells,
however that came about. So does a coupon with its travel. With all moduli c times as large the
readings are those at the pressure p/c, and c times those of a force
(:mod:`dolfingrip.diagnosis.simulation.variants`).

Viscosity is another load, nearly: quasi-linear viscoelasticity.

All stresses of a body follow from its elastic ones by the same linear law of relaxation
(Fung, Biomechanics, Springer 1993, sect. 7.6), with branches of the parts gᵢ and times τᵢ

    σ(t) = σ_el(t) + Σ rᵢ vᵢ(t),    vᵢ' = σ_el' − vᵢ/τᵢ,    rᵢ = gᵢ/(1 − Σ g).

So do the loads that hold it in balance: the pressure p and the blocked force F are those of an
elastic body, q and F_el(q), relaxed. A finger under the pressure p turns as an elastic one under q:

    α(t) = α_el(q(t)),    F(t) = F_el(q(t)) + Σ rᵢ vᵢ(t),    p = q + Σ rᵢ wᵢ,  wᵢ' = q' − wᵢ/τᵢ.

A coupon's travel is given, so its force is that of the elastic coupon, relaxed. Contact, large
rotations and the network of :mod:`dolfingrip.forms.transient_network` are not linear. A blocked
finger does not follow the elastic load, so that its contact opens otherwise in unloading: the law
is near in free bending, and off in a blocked force. Simulations correct it
(:func:`dolfingrip.diagnosis.finger.closed_forms.approximate`); nothing is judged by it alone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.channels import CHANNELS, PRESSURE
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.schedule import StopSchedule
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings
from dolfingrip.extensions.effect import Drifting, Flow, Relaxing, Stage


def relaxed(viscous: Relaxing, time_s: np.ndarray, elastic: np.ndarray) -> np.ndarray:
    """(stops,) a load from the elastic one, straight between stops, at rest before the first."""
    found = []
    branches = _Branches(viscous)
    for moment_s, value in zip(time_s, elastic, strict=True):
        branches.pass_time(moment_s)
        branches.load(value)
        found.append(value + branches.more)
    return np.array(found)


def elastic_load(viscous: Relaxing, time_s: np.ndarray, load: np.ndarray) -> np.ndarray:
    """(stops,) the elastic load that relaxes to ``load``: the inverse of :func:`relaxed`."""
    found = []
    branches = _Branches(viscous)
    for moment_s, value in zip(time_s, load, strict=True):
        branches.pass_time(moment_s)
        found.append(branches.solve(value))
        branches.load(found[-1])
    return np.array(found)


class _Branches:
    """Maxwell branches under an elastic load that changes along straight lines.

    Args:
        viscous: their parts and times.
    """

    def __init__(self, viscous: Relaxing) -> None:
        parts, times = viscous.branches()
        g = np.array(parts)
        self._tau_s: np.ndarray = np.array(times)
        self._ratio: np.ndarray = g / (1 - g.sum())
        self._stress: np.ndarray = np.zeros(len(g))
        self._kept: np.ndarray = np.ones(len(g))
        self._time_s = self._value = 0.0

    def pass_time(self, moment_s: float) -> None:
        """Relax until a moment; the load that is reached by then is told next."""
        part = (moment_s - self._time_s) / self._tau_s
        self._stress = self._stress * np.exp(-part)
        # the mean of exp(-t/τ) over the step: what is left of a load that grows along it
        self._kept = np.where(part > 0, -np.expm1(-part) / np.where(part > 0, part, 1.0), 1.0)
        self._time_s = moment_s

    def solve(self, load: float) -> float:
        """The elastic load that makes ``load`` at this moment."""
        rest = load - float(self._ratio @ (self._stress - self._kept * self._value))
        return rest / (1 + float(self._ratio @ self._kept))

    def load(self, value: float) -> None:
        """Load elastically to ``value``."""
        self._stress = self._stress + self._kept * (value - self._value)
        self._value = value

    @property
    def more(self) -> float:
        """Load that the branches add to the elastic one."""
        return float(self._ratio @ self._stress)


def viscous_change(
    measurement: Measurement, base: SimulatedReadings, viscous: Relaxing, factor: float
) -> np.ndarray:
    """(n,) change of the readings by viscosity, nearly.

    Args:
        measurement: that ``base`` was simulated for.
        base: without memory and clock.
        viscous: the effect.
        factor: of all moduli; other than 1 where these scale.
    """

    def load(way: StopSchedule) -> np.ndarray:
        return elastic_load(viscous, np.array(way.time_s), np.array(way.value))

    def shown(way: StopSchedule, column: str, elastic: np.ndarray) -> np.ndarray:
        if not CHANNELS[column].in_proportion:  # no load
            return elastic
        return relaxed(viscous, np.array(way.time_s), elastic)

    return change(measurement, base, load, factor, shown)


Load = Callable[[StopSchedule], np.ndarray]
"""(stops,) pressure on the elastic body along a way through time, in kPa."""

Shown = Callable[[StopSchedule, str, np.ndarray], np.ndarray]
"""(stops,) readings of a column along a way, by those of the elastic body."""


def change(
    measurement: Measurement,
    base: SimulatedReadings,
    load: Load,
    factor: float = 1.0,
    shown: Shown | None = None,
) -> np.ndarray:
    """(n,) change of the readings.

    Args:
        measurement: that ``base`` was simulated for.
        base: without memory and clock.
        load: that an elastic body has to bear to be as the real one is; the travel of a coupon is
            what it is.
        factor: of all moduli; other than 1 where these scale.
        shown: what is read of it; the elastic body's readings where None.
    """
    row = measurement.listed()["row"].to_numpy()
    found = np.zeros(len(row))
    for run in base.runs:
        way = run.group.in_time
        (curve,) = run.schedule.legs
        here = there = np.array(way.value)
        if way.control == PRESSURE.name:
            here, there = here / factor, load(way) / factor
        for name, at in measurement.places(run.group.tests).items():
            values = run.result.columns.get(name, np.empty(0))
            if not values.size:
                continue
            size = factor if CHANNELS[name].in_proportion else 1.0
            elastic, readings = (size * curve.read(values, load_at) for load_at in (here, there))
            if shown is not None:
                readings = shown(way, name, readings)
            found[at] = way.at_rows(readings - elastic, len(measurement.readings))[row[at]]
    return found


def behind(stage: Stage, way: StopSchedule) -> np.ndarray:
    """(stops,) pressure behind a stage of the supply along a way that begins at rest, in kPa."""
    found = []
    time_s, inlet_kPa, outlet_kPa = 0.0, 0.0, 0.0
    for moment_s, now_kPa in zip(way.time_s, way.value, strict=True):
        flow = Flow(inlet_kPa, now_kPa, outlet_kPa, moment_s, moment_s - time_s)
        outlet_kPa = stage.outlet_kPa(flow)
        time_s, inlet_kPa = moment_s, now_kPa
        found.append(outlet_kPa)
    return np.array(found)


def drifted(
    measurement: Measurement, base: SimulatedReadings, drift: Drifting, factor: float
) -> np.ndarray:
    """(n,) change of the readings where all moduli drift; arguments as of :func:`change`."""

    def soft(way: StopSchedule) -> np.ndarray:
        return drift.moduli_at(np.array(way.time_s))

    def shown(way: StopSchedule, column: str, elastic: np.ndarray) -> np.ndarray:
        return soft(way) * elastic if CHANNELS[column].in_proportion else elastic

    def load(way: StopSchedule) -> np.ndarray:
        return np.array(way.value) / soft(way)

    return change(measurement, base, load, factor, shown)

"""Readings that follow from the elastic curve at another load: no simulation is needed.

A finger without memory, friction and clock turns and presses as the pressure in its cavity tells,
however that came about. So does a coupon with its travel. With all moduli c times as large the
readings are those at the pressure p/c, and c times those of a force
(:mod:`dolfingrip.diagnosis.simulation.modulus`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.channels import CHANNELS, PRESSURE
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.legs import Route
from dolfingrip.diagnosis.simulation.simulated import Simulated
from dolfingrip.extensions.effect import Drifting, Flow, Stage

Load = Callable[[Route], np.ndarray]
"""(stops,) pressure on the elastic body along a way through time, in kPa."""

Shown = Callable[[Route, str, np.ndarray], np.ndarray]
"""(stops,) readings of a column along a way, by those of the elastic body."""


def change(
    measurement: Measurement,
    base: Simulated,
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
        (curve,) = run.route.legs
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


def behind(stage: Stage, way: Route) -> np.ndarray:
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
    measurement: Measurement, base: Simulated, drift: Drifting, factor: float
) -> np.ndarray:
    """(n,) change of the readings where all moduli drift; arguments as of :func:`change`."""

    def soft(way: Route) -> np.ndarray:
        return drift.moduli_at(np.array(way.time_s))

    def shown(way: Route, column: str, elastic: np.ndarray) -> np.ndarray:
        return soft(way) * elastic if CHANNELS[column].in_proportion else elastic

    def load(way: Route) -> np.ndarray:
        return np.array(way.value) / soft(way)

    return change(measurement, base, load, factor, shown)

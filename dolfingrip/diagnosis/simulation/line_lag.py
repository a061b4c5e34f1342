"""A line that lags behind the regulator, where history does not matter: no simulation is needed.

A finger without memory, friction and clock turns and presses as the pressure in its cavity tells,
however that came about. Behind a line of time constant τ that pressure follows from the
regulator's alone, so its readings are those of the elastic curve there:

    y(t) = y_el(p_out(t)),    τ dp_out/dt = p_in − p_out

With all moduli c times as large it is y_el(p_out/c), and c y_el(p_out/c) of a force.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.groups import path_independent
from dolfingrip.diagnosis.simulation.legs import Route
from dolfingrip.diagnosis.simulation.simulated import Simulated
from dolfingrip.extensions.effect import Flow
from dolfingrip.extensions.line_lag import LineLag

NAME: Final = LineLag.name()

FAR: Final = 1e6
"""Part of the range that a base simulation reached, by which its straight line is followed. Beyond
it no readings are judged, so that any number does there."""


def serves(effect: str, config: Config) -> bool:
    """Whether an effect beside ``config`` is a line's lag that the elastic curve tells."""
    return effect == NAME and path_independent(config)


def line(config: Config) -> LineLag:
    """That of a configuration that has one."""
    return next(each for each in config.extensions.active() if isinstance(each, LineLag))


def behind(line: LineLag, way: Route) -> np.ndarray:
    """(stops,) pressure behind a line at the stops of a way that begins at rest, in kPa."""
    found = []
    time_s, inlet_kPa, outlet_kPa = 0.0, 0.0, 0.0
    for moment_s, now_kPa in zip(way.time_s, way.value, strict=True):
        flow = Flow(inlet_kPa, now_kPa, outlet_kPa, moment_s, moment_s - time_s)
        outlet_kPa = line.outlet_kPa(flow)
        time_s, inlet_kPa = moment_s, now_kPa
        found.append(outlet_kPa)
    return np.array(found)


def change(
    measurement: Measurement, base: Simulated, line: LineLag, factor: float = 1.0
) -> np.ndarray:
    """(n,) change of the readings by a line.

    Args:
        measurement: that ``base`` was simulated for.
        base: without a line's lag, and without memory.
        line: that lags.
        factor: of all moduli; other than 1 where these scale
            (:mod:`dolfingrip.diagnosis.simulation.modulus`).
    """
    listed = measurement.listed()
    place, column, test = (listed[name].to_numpy() for name in ("row", "column", "test"))
    count = len(measurement.readings)
    found = np.zeros(len(listed))
    for run in base.runs:
        way = run.group.in_time
        if way.led != "pressure_kPa":
            continue
        (curve,) = run.route.legs
        inlet_kPa, outlet_kPa = np.array(way.value), behind(line, way)
        mine = np.isin(test, run.group.tests)
        for name in set(column[mine]):
            values = run.result.columns.get(str(name), np.empty(0))
            if not values.size:
                continue
            padded = np.zeros(len(curve.stops))
            padded[: len(values)] = values
            there, here = (
                curve.weights(len(values), at / factor, outside=FAR) @ padded
                for at in (outlet_kPa, inlet_kPa)
            )
            at = np.flatnonzero(mine & (column == name))
            by = factor if name == "force_N" else 1.0
            found[at] = by * way.at_rows(there - here, count)[place[at]]
    return found

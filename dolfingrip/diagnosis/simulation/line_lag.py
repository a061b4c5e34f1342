"""A line that lags behind the regulator, where history does not matter: no simulation is needed.

Behind a line of time constant τ the pressure follows from the regulator's alone, so the readings
are those of the elastic curve there (:mod:`dolfingrip.diagnosis.simulation.elastic_curve`):

    y(t) = y_el(p_out(t)),    τ dp_out/dt = p_in − p_out

With all moduli c times as large it is y_el(p_out/c), and c y_el(p_out/c) of a force.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import elastic_curve
from dolfingrip.diagnosis.simulation.groups import path_independent
from dolfingrip.diagnosis.simulation.legs import Route
from dolfingrip.diagnosis.simulation.simulated import Simulated
from dolfingrip.extensions.effect import Effect, Flow
from dolfingrip.extensions.index import effect


def is_stage(name: str) -> bool:
    """Whether an effect is a stage of the supply whose readings the elastic curve tells."""
    return effect(name).by_elastic_curve == "stage"


def serves(name: str, config: Config) -> bool:
    """Whether an effect beside ``config`` is a stage that the elastic curve tells."""
    return is_stage(name) and path_independent(config)


def behind(line: Effect, way: Route) -> np.ndarray:
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
    measurement: Measurement, base: Simulated, line: Effect, factor: float = 1.0
) -> np.ndarray:
    """(n,) change of the readings by a line.

    Args:
        measurement: that ``base`` was simulated for.
        base: without a line's lag, and without memory.
        line: that lags.
        factor: of all moduli; other than 1 where these scale
            (:mod:`dolfingrip.diagnosis.simulation.modulus`).
    """
    return elastic_curve.change(measurement, base, partial(behind, line), factor)

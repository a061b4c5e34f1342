"""A line that lags behind the regulator, where history does not matter: no simulation is needed.

Behind a line of time constant τ the pressure follows from the regulator's alone, so the readings
are those of the elastic curve there (:mod:`dolfingrip.diagnosis.simulation.elastic_curve`):

    y(t) = y_el(p_out(t)),    τ dp_out/dt = p_in − p_out

With all moduli c times as large it is y_el(p_out/c), and c y_el(p_out/c) of a force.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.diagnosis.simulation.legs import Route
from dolfingrip.extensions.effect import Effect, Flow


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

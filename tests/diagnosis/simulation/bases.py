"""The model of a measurement as configured, in one call."""

from __future__ import annotations

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.simulation import (
    FingerSimulation,
    finger_simulation,
    rough_simulation,
)
from dolfingrip.diagnosis.simulation.meshes import coarser
from dolfingrip.diagnosis.simulation.runner import Workers


def simulated(measurement: Measurement, config: Config, workers: Workers) -> FingerSimulation:
    """On the graded mesh and on that of the causes."""
    rough = rough_simulation(measurement, config, workers, coarser(config)[0], 1.0)
    return finger_simulation(rough, rough)

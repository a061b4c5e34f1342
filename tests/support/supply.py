"""The way from the regulator to the cavity, without a finger."""

from __future__ import annotations

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfingrip.config import KPA
from dolfingrip.extensions.set_point_logged import SetPointLogged
from dolfingrip.extensions.supply import Supply
from dolfingrip.mechanics.model.model import Control

TAU = 0.7
"""Time constant of the line where no stages are given (s)."""


def cavity_pressures(times_s: np.ndarray, pressures_kPa: np.ndarray, *stages: object) -> np.ndarray:
    """Cavity pressure as the regulator passes through the points of a polygon."""
    cavity = Control(fem.Constant(mesh.create_unit_interval(MPI.COMM_SELF, 1), 0.0), KPA)
    supply = Supply(cavity, stages or [SetPointLogged(tau_s=TAU)])  # type: ignore[arg-type]
    found, before = [], 0.0
    for time_s, pressure in zip(times_s, pressures_kPa, strict=True):
        supply.set(float(pressure))
        supply.set_time(float(time_s), float(time_s) - before)
        found.append(cavity.value)
        supply.accept()
        before = time_s
    return np.array(found)

"""Noise, gauges, nuisances and the mesh of a finger's readings, as one covariance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dolfingrip.diagnosis.answer.errors import SLACK, Errors, followed, lying, together
from dolfingrip.diagnosis.core.discrepancy import Along
from dolfingrip.diagnosis.finger.simulation import FingerSimulation
from dolfingrip.diagnosis.policy import MODEL
from dolfingrip.diagnosis.simulation.nuisances import WALL

FITTED = ("modulus",)
"""Nuisances that every hypothesis fits."""


def errors(simulation: FingerSimulation) -> Errors:
    """The covariance of a finger's readings, and of coupons beside it."""
    measurement, base = simulation.measurement, simulation.base
    listed = measurement.listed()
    along = _along(simulation)
    signal = base.readings * followed(listed, along, base.readings)[0]
    steep = np.nan_to_num(base.by_control) * _steeper(base.readings, signal)
    told = (*FITTED, *([WALL] if simulation.walls else []))
    shared = [
        replace(each, change=np.nan_to_num(each.change))
        for each in simulation.nuisances
        if each.name not in told
    ]
    columns = list(np.nan_to_num(simulation.mesh.T))
    for test in measurement.tests:
        if test.experiment == "coupon":
            own = np.where(listed["test"].to_numpy() == test.number, steep, 0.0)
            columns.append(own * test.setup.nuisances[SLACK])
    rest = np.zeros((len(listed), len(listed))) + sum(np.outer(each, each) for each in columns)
    return together(measurement, along, signal, steep, shared, rest)


def _steeper(base: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """How much more the readings change than the model does."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(np.abs(base) > 1e-9, signal / base, 1.0)
    return np.clip(np.nan_to_num(ratio, nan=1.0), 1 / MODEL.steepest, MODEL.steepest)


def _along(simulation: FingerSimulation) -> Along:
    rows = simulation.measurement.readings
    number, load = rows["test"].to_numpy(), np.zeros(len(rows))
    for test in simulation.measurement.tests:
        mine = np.flatnonzero(number == test.number)
        own = rows[test.control].to_numpy()[mine]
        load[mine] = own / (float(np.nanmax(np.abs(own))) or 1.0)
    return lying(simulation.measurement, simulation.groups, load)

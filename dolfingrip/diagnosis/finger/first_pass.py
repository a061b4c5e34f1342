"""The mesh that causes are simulated on, and about which moduli: both by the model without causes.

A simulation costs what its mesh and its deformation cost, and a diagnosis makes some 150. So the
model is first simulated on the coarsest mesh. Where its moduli do not follow the readings, it is
simulated anew with those that do. A finer mesh is taken where it comes farther, or where the graded
one reads otherwise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.model import baseline_problem, errors, fitted_moduli
from dolfingrip.diagnosis.finger.simulation import (
    FingerSimulation,
    finger_simulation,
    rough_simulation,
)
from dolfingrip.diagnosis.policy import MODEL, POLICY
from dolfingrip.diagnosis.simulation import meshes
from dolfingrip.diagnosis.simulation.runner import Workers


def first_pass(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    say: Callable[[str], None] = lambda text: None,
) -> tuple[FingerSimulation, FingerSimulation]:
    """The model on the coarsest mesh that bears the load, with moduli that follow the readings.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        say: told what is being done.

    Returns:
        With these moduli, and as configured.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    say("simulating the measurement as configured")
    found: list[FingerSimulation] = []
    configured = None
    for mesh in meshes.coarser(config):
        centre = found[-1].centre if found else 1.0
        told = rough_simulation(measurement, config, workers, mesh, centre)
        configured = configured or told
        for _ in range(POLICY.passes):
            centre = _moduli(told)
            if centre == told.centre:
                break
            say(f"the moduli are about {centre:.2g} times those configured; simulating there")
            told = rough_simulation(measurement, config, workers, mesh, centre)
        told = truncate_before_failure(told)
        if found and _reached(told) <= _reached(found[-1]):
            break
        found.append(told)
        if _reached(told) == len(told.plain.readings):
            break
    assert configured is not None
    return found[-1], configured


def refine_until_consistent(
    rough: FingerSimulation, configured: FingerSimulation
) -> FingerSimulation:
    """The whole simulation, its causes on a finer mesh where the graded one reads otherwise.

    Args:
        rough, configured: of the first pass.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    every = meshes.coarser(rough.config)
    finer = every[every.index(rough.flat) + 1 :]
    while True:
        found = finger_simulation(rough, configured)
        if not finer or _off(found) < POLICY.coarse:
            return found
        mesh, *finer = finer
        rough = rough_simulation(
            rough.measurement, rough.config, rough.workers, mesh, rough.centre, rough.headroom
        )


def _moduli(rough: FingerSimulation) -> float:
    reached = np.isfinite(rough.base.readings)
    readings = np.where(reached, rough.base.readings, 0.0)
    whole = replace(rough, base=replace(rough.base, readings=readings))
    plain = baseline_problem(whole, errors(whole)).rows(reached)
    # walls are not fitted yet: they may take their part
    return fitted_moduli(plain, rough.centre, POLICY.recentred)


def truncate_before_failure(simulation: FingerSimulation) -> FingerSimulation:
    """Simulate no farther than it comes, where it ends beyond the readings.

    To find out where a path ends takes many times what comes before.
    """
    headroom = simulation.headroom
    for run in simulation.plain.runs:
        values = np.abs(run.schedule.value)
        reached = min((len(v) for v in run.result.columns.values() if len(v)), default=0)
        rows = max(float(np.abs(leg.rows_at).max()) for leg in run.schedule.legs if leg.rows.size)
        if run.result.failure is not None and reached > 1:
            headroom = min(headroom, max(MODEL.reached * float(values[reached - 1]) / rows, 1.0))
    if headroom == simulation.headroom:
        return simulation
    return rough_simulation(
        simulation.measurement,
        simulation.config,
        simulation.workers,
        simulation.flat,
        simulation.centre,
        headroom,
    )


def _reached(rough: FingerSimulation) -> int:
    return int(np.isfinite(rough.plain.readings).sum())


def _off(found: FingerSimulation) -> float:
    """Largest difference of a channel between both meshes, by its size; root mean squares."""
    column = found.measurement.listed()["column"].to_numpy()
    graded, plain = found.base.readings, found.plain.readings
    off = []
    for name in set(column):
        mine = (column == name) & np.isfinite(graded + plain)
        size = float(np.square(graded[mine]).mean())
        off.append(float(np.square(graded[mine] - plain[mine]).mean()) / size if size else 0.0)
    return float(np.sqrt(max(off)))

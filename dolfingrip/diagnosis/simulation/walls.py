"""Other walls: the base simulation with thinner and with thicker ones, and what lies between.

Where bellows touch one another, the derivative of the blocked force by the walls' thickness jumps,
and other walls move that jump. Taken as linear, walls that are 10 % too thin leave 3 standard
deviations of the reference finger's readings unexplained. So the base model is simulated with walls
to either side, and with others that readings may ask for. A polynomial leads through all
(:func:`dolfingrip.diagnosis.finger.model.model_case`). Moduli scale each of the simulations exactly
(:mod:`dolfingrip.diagnosis.simulation.modulus`).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import MODEL
from dolfingrip.diagnosis.simulation import modulus
from dolfingrip.diagnosis.simulation.nuisances import WALL, WALLS
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import Simulated, simulate
from dolfingrip.parameter import every


def simulate_walls(
    measurement: Measurement,
    config: Config,
    base: Simulated,
    workers: Workers,
    further: Collection[float] = (),
) -> dict[float, Simulated]:
    """Simulate a finger that is blocked with other walls.

    Args:
        measurement: that ``base`` was simulated for.
        config: the model that is diagnosed.
        base: of it.
        workers: where simulations are computed and kept.
        further: thicknesses by that configured that are to be simulated, too; left out where not
            all readings are reached.

    Returns:
        By the walls' thickness by that configured, the base simulation among them. Empty where a
        linear nuisance serves, as nothing is blocked or the walls are known; or where moduli do not
        scale, specimens have different walls, or thinner ones do not reach all readings.

    Raises:
        ConfigError: one line: no workers, or a store in use.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    bodies = [run for run in base.runs if run.group.experiment != "coupon"]
    blocked = any(run.group.experiment == "blocked_force" for run in bodies)
    spread = min(test.setup.nuisances[WALL] for test in measurement.tests)
    found = {(p.key, p.value(run.config)) for run in bodies for p in every(run.config)
             if p.key in WALLS}  # fmt: skip
    if not (
        blocked and modulus.scale_all(base.runs) and spread >= MODEL.walls_known and len(found) == 1
    ):
        return {}
    ((key, wall_mm),) = found
    stages = base.case.overrides
    fingers = frozenset(run.group.experiment for run in bodies)
    usual = (1 - MODEL.walls_by, 1 + MODEL.walls_by)
    cases = [
        replace(
            base.case, overrides={**stages, key: wall_mm * by}, gradients=(),
            only_in=fingers, elsewhere=stages,
        )
        for by in (*usual, *further)
    ]  # fmt: skip
    simulated = simulate(measurement, config, cases, workers)
    kept = np.isfinite(base.readings)
    known = {
        by: each
        for by, each in zip((*usual, *further), simulated, strict=True)
        if np.isfinite(each.readings[kept]).all()
    }
    return {**known, 1.0: base} if set(usual) <= set(known) else {}

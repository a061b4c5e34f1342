"""The base model at other moduli, exactly and without a new simulation, and at other walls.

Without weight and without time, equilibrium depends on pressure by modulus alone:

    α(p; cμ) = α(p/c; μ),    F(p; cμ) = c F(p/c; μ),    coupon: F(u; cμ) = c F(u; μ)

where the contacts' stiffness, an energy per volume, too, is c times as large. A change of ±20 %
taken as linear leaves 1.6 standard deviations unexplained, this none.

Other walls are simulated. Where bellows touch one another, the derivative of the blocked force by
the walls' thickness jumps, and other walls move that jump. Taken as linear, walls that are 10 % too
thin leave 3 standard deviations of the reference finger's readings unexplained. So the base model
is simulated with walls to either side, and with others that readings may ask for. A polynomial
leads through all (:func:`dolfingrip.diagnosis.finger.model.baseline_problem`). Moduli scale each of
the simulations exactly.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from dolfingrip import parameter
from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import MODEL
from dolfingrip.diagnosis.simulation.groups import path_independent
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import SimulatedGroup, SimulatedReadings, simulate
from dolfingrip.parameter.nuisances import WALL, wall_key


def simulate_walls(
    measurement: Measurement,
    config: Config,
    base: SimulatedReadings,
    workers: Workers,
    further: Collection[float] = (),
) -> dict[float, SimulatedReadings]:
    """Simulate a finger with other walls, if it is blocked or readings have no derivative by them.

    Args:
        measurement: that ``base`` was simulated for.
        config: the model that is diagnosed.
        base: of it.
        workers: where simulations are computed and kept.
        further: thicknesses by that configured that are to be simulated, too; left out where not
            all readings are reached.

    Returns:
        By the walls' thickness by that configured, the base simulation among them. Empty where a
        linear nuisance serves, as nothing is blocked or the walls are known; where there are no
        walls; or where moduli do not scale, specimens have different walls, or thinner ones do not
        reach all readings.

    Raises:
        ConfigError: one line: no workers, or a store in use.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    bodies = [run for run in base.runs if run.group.experiment != "coupon"]
    blocked = any(run.group.experiment == "blocked_force" for run in bodies)
    spread = min(test.setup.nuisances[WALL] for test in measurement.tests)
    found = {(wall_key(run.config), run.config.geometry.wall_mm) for run in bodies}
    linear = all(run.config.geometry.movable("wall_mm") for run in bodies)
    known = spread < MODEL.walls_known or len(found) != 1
    if known or not scale_all(base.runs) or (linear and not blocked):
        return {}
    ((key, wall_mm),) = found
    if key is None:
        return {}
    stages = base.variant.overrides
    fingers = frozenset(run.group.experiment for run in bodies)
    usual = (1 - MODEL.walls_by, 1 + MODEL.walls_by)
    variants = [
        replace(
            base.variant, overrides={**stages, key: wall_mm * by}, gradients=(),
            only_in=fingers, elsewhere=stages,
        )
        for by in (*usual, *further)
    ]  # fmt: skip
    simulated = simulate(measurement, config, variants, workers)
    kept = np.isfinite(base.readings)
    reached = {
        by: each
        for by, each in zip((*usual, *further), simulated, strict=True)
        if np.isfinite(each.readings[kept]).all()
    }
    return {**reached, 1.0: base} if set(usual) <= set(reached) else {}


def scales(config: Config) -> bool:
    """Tell whether the scaling is exact: no weight, memory, clock, or modulus of an effect's own.

    Beside effects in general it is not: their parameters are moduli, compliances or offsets.
    Those that are at their neutral values do not matter.
    """
    if config.gravity.acceleration_m_s2 or not path_independent(config):
        return False
    return all(_is_neutral(effect) for effect in config.extensions.active())


def _is_neutral(effect: object) -> bool:
    neutral = getattr(effect, "neutral", {})
    return all(getattr(effect, key) == value for key, value in neutral.items())


def scale_all(runs: Sequence[SimulatedGroup]) -> bool:
    """Return whether it is exact for all simulations of a measurement."""
    return all(run.group.curve is not None and scales(run.config) for run in runs)


def overrides(config: Config, factor: float) -> Change:
    """Return the change that makes all moduli ``factor`` times as large, contacts' stiffness too.

    Args:
        config: whose moduli they are.
        factor: above 0.
    """
    return {
        **parameter.scaled(config, factor),
        "contact.stiffness_MPa": config.contact.stiffness_MPa * factor,
        "plate.stiffness_MPa": config.plate.stiffness_MPa * factor,
    }

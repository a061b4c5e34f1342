"""Other walls: the base simulation with thinner and with thicker ones, and what lies between.

Where bellows touch one another, the derivative of the blocked force by the walls' thickness jumps,
and other walls move that jump. Taken as linear, walls that are 10 % too thin leave 3 standard
deviations of the reference finger's readings unexplained. So the base model is simulated with walls
to either side, and a parabola leads through the three at each reading:

    y(w) = y(1) + (y₊ − y₋)/2 x + (y₊ + y₋ − 2 y(1))/2 x²,    x = (w − 1)/δ

and on along its tangent where |x| > 1. Moduli scale each of the three exactly
(:mod:`dolfingrip.diagnosis.simulation.modulus`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import meshes, modulus
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.nuisances import WALL, WALLS
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import Case, Simulated, simulate
from dolfingrip.parameter import every

PART: Final = 0.1
"""δ: relative change of the walls' thickness that is simulated, two usual standard deviations."""

KNOWN: Final = 0.01
"""Standard deviation of the walls from which on they are simulated; smaller ones are linear."""


@dataclass(frozen=True)
class WallCurves:
    """Readings at any thickness of the walls, without a new simulation.

    Attributes:
        measurement: of all arrays.
        thinner, usual, thicker: the base simulation with each walls, with headroom.
        ungraded: readings of the three on the ungraded mesh, shape (3, n); None where there is no
            second mesh.
    """

    measurement: Measurement
    thinner: Simulated
    usual: Simulated
    thicker: Simulated
    ungraded: np.ndarray | None = None

    def change(self, walls: float, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """(n,) change of the readings by the walls, and its derivative by them.

        Args:
            walls: thickness by that configured.
            factor: of all moduli.
        """
        three = [
            modulus.scaled(self.measurement, each, factor)
            for each in (self.thinner, self.usual, self.thicker)
        ]
        return _between(np.array(three), walls)

    def mesh(self, walls: float) -> np.ndarray:
        """(n,) by how much more the mesh is off than with the walls as configured.

        As for these, :data:`~dolfingrip.diagnosis.simulation.meshes.SHARE` of what grading changes:
        thinner walls bend further, and a mesh is off by more then.
        """
        if self.ungraded is None:
            return np.zeros(len(self.usual.readings))
        graded = np.array([s.readings for s in (self.thinner, self.usual, self.thicker)])
        return meshes.SHARE * _between(graded - self.ungraded, walls)[0]


def _between(three: np.ndarray, walls: float) -> tuple[np.ndarray, np.ndarray]:
    """(n,) change from the second row by the parabola through all three, and its derivative."""
    below, here, above = three
    slope, curvature = (above - below) / 2, above + below - 2 * here
    x = (walls - 1) / PART
    inside = min(max(x, -1.0), 1.0)
    tangent = slope + curvature * inside
    found = slope * inside + 0.5 * curvature * inside**2 + tangent * (x - inside)
    return np.nan_to_num(found), np.nan_to_num(tangent / PART)


def simulate_walls(
    measurement: Measurement, base: BaseSimulation, workers: Workers
) -> WallCurves | None:
    """Simulate a finger that is blocked with other walls.

    Args:
        measurement: that ``base`` was simulated for.
        base: of it.
        workers: where simulations are computed and kept.

    Returns:
        None where a linear nuisance serves, as nothing is blocked or the walls are known; or where
        moduli do not scale, specimens have different walls, or thinner ones do not reach all
        readings.

    Raises:
        ConfigError: one line: no workers, or a store in use.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    bodies = [run for run in base.simulated.runs if run.group.experiment != "coupon"]
    blocked = any(run.group.experiment == "blocked_force" for run in bodies)
    spread = min(test.setup.nuisances[WALL] for test in measurement.tests)
    found = {(p.key, p.value(run.config)) for run in bodies for p in every(run.config)
             if p.key in WALLS}  # fmt: skip
    if not (blocked and base.scales and spread >= KNOWN and len(found) == 1):
        return None
    ((key, wall_mm),) = found
    stages = base.simulated.case.overrides
    flat = () if base.plain is None else base.plain.case.overrides
    fingers = frozenset(run.group.experiment for run in bodies)

    def case(way: int, others: tuple[str, ...], *, headroom: bool) -> Case:
        moved = (*others, f"{key}={wall_mm * (1 + way * PART)!r}")
        return Case(moved, headroom=headroom, only_in=fingers, elsewhere=others)

    cases = [case(way, stages, headroom=True) for way in (-1, 1)]
    if flat:
        cases += [case(way, flat, headroom=False) for way in (-1, 1)]
    thinner, thicker, *plain = simulate(measurement, base.config, cases, workers)
    kept = np.isfinite(base.readings)
    for each in (thinner, thicker):
        if not np.isfinite(each.readings[kept]).all():
            return None
    rough = None
    if base.plain is not None and plain:
        rough = np.array([plain[0].readings, base.plain.readings, plain[1].readings])
    return WallCurves(measurement, thinner, base.simulated, thicker, rough)

"""The model of fingers without causes, as a case: any moduli, and any walls that are fitted."""

from __future__ import annotations

import numpy as np

from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.case import Case
from dolfingrip.diagnosis.core.curved import Coordinate, Simulations, trained_on
from dolfingrip.diagnosis.core.evidence import Fit, Level
from dolfingrip.diagnosis.core.scaled import Factor
from dolfingrip.diagnosis.core.search import levels
from dolfingrip.diagnosis.finger.simulation import FingerSimulation, same_material
from dolfingrip.diagnosis.finger.unknowns import WALLS
from dolfingrip.diagnosis.policy import MODEL, POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL


def wall_std(simulation: FingerSimulation) -> float:
    """Relative standard deviation of the walls; 0 where they are a linear nuisance."""
    if not simulation.walls:
        return 0.0
    return min(t.setup.nuisances[WALL] for t in simulation.measurement.tests)


def model_case(simulation: FingerSimulation, off: Errors) -> Case:
    """The case without causes, whose ground is the model at any moduli and walls."""
    measurement = simulation.measurement
    listed = measurement.listed()
    n = len(listed)
    std = max(t.setup.nuisances["modulus"] for t in measurement.tests)
    free = same_material(measurement, simulation.config) and std > 0
    std = std if free else 1e-6
    ends = np.log(simulation.centre) + np.log(POLICY.stiffest) * np.array([-1.0, 1.0])
    ends = ends / std if free else np.array([-1.0, 1.0])
    factor = Factor(std, *map(float, ends))
    nodes = nodes_of(ends)
    spread = wall_std(simulation)
    known = sorted(simulation.walls)
    values = []
    for c in map(float, factor(nodes)):
        by = c / simulation.centre
        told = [simulation.at(simulation.walls[walls], by) for walls in known]
        told = told or [simulation.base_at(c)]
        values.append([np.nan_to_num(each - simulation.base.readings) for each in told])
    told_values = np.array(values)
    zeta = (np.array(known)[:, None] - 1) / spread if spread else np.zeros((1, 0))
    slopes = np.zeros((len(nodes), len(zeta), zeta.shape[1], n))
    if spread:
        slopes[:] = np.nan
    own = [Coordinate(lambda zeta: zeta, amplitude=False)] if spread else []
    every = Simulations(zeta, told_values, slopes, nodes)
    takes = tuple(range(1 + len(own)))
    ground = trained_on(every, own, off.noise, takes, exact=True)
    others = np.tile([-POLICY.walls_reach, POLICY.walls_reach], (len(own), 1))
    names = ((("modulus",) if free else ()), (WALLS,))[: 1 + len(own)]
    return Case(
        listed["value"].to_numpy(), simulation.base.readings, factor, {}, off.covariance,
        discrepancy.kernel(off.along), {}, ground, others=others, ground_names=names,
    )  # fmt: skip


def spread(even: np.ndarray) -> np.ndarray:
    """ζ of moduli, nearer to one another where these are as told, from evenly spread numbers."""
    return np.asarray(np.sinh(MODEL.closer * even) / MODEL.closer)


def even(zeta: float | np.ndarray) -> np.ndarray:
    """The inverse of :func:`spread`."""
    return np.asarray(np.arcsinh(MODEL.closer * np.asarray(zeta)) / MODEL.closer)


def nodes_of(ends: np.ndarray) -> np.ndarray:
    """ζ of the moduli that a simulation is read at.

    Args:
        ends: range of ζ, shape (2,).
    """
    low, high = even(ends)
    return spread(np.linspace(low, high, POLICY.nodes))


def fitted_moduli(plain: Case, known: float, slack: float) -> float:
    """The fitted factor of all moduli; a known one where that is near.

    In few steps, so that another measurement of the finger finds its simulations.

    Args:
        plain: the model without causes.
        known: factor of all moduli that it was simulated at.
        slack: ratio of both up to which they are near.
    """
    factor = float(plain.factor(_fitted(plain)[0]))
    if abs(np.log(factor / known)) <= np.log(slack):
        return known
    step = np.log(POLICY.recentred)
    return float(np.exp(step * np.round(np.log(factor) / step)))


def fitted_walls(plain: Case, spread: float) -> float:
    """The fitted thickness of the walls by that configured, in few steps.

    Args:
        plain: the model without causes.
        spread: relative standard deviation of the walls.
    """
    walls = 1 + spread * float(_fitted(plain)[1])
    step = MODEL.walls_by / 2
    return float(np.round(step * np.round(walls / step), 9))


def plain_fit(plain: Case, level: Level) -> Fit:
    """The fit of the model without causes, under one discrepancy; its numbers may be far off."""
    rest = np.zeros(plain.own - 1)
    return level.of(tuple(plain.far)).fit([np.r_[start, rest] for start in POLICY.starts])


def _fitted(plain: Case) -> np.ndarray:
    """ζ under whichever discrepancy the model without causes needs."""
    fits = [plain_fit(plain, Level(plain, level)) for level in levels()]
    return max(fits, key=lambda fit: fit.log_evidence).zeta

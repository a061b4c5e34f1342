"""The model of fingers without causes: any moduli, any walls that are fitted, and all errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dolfingrip.diagnosis.answer.errors import Errors, errors_of, kernel
from dolfingrip.diagnosis.core.evidence import CovarianceModel, MapFit
from dolfingrip.diagnosis.core.polynomial import Coordinate, SimulatedChanges, trained_on
from dolfingrip.diagnosis.core.problem import InferenceProblem
from dolfingrip.diagnosis.core.search import levels
from dolfingrip.diagnosis.core.unknown import MODULUS, Factor, Unknown, factor_of_moduli
from dolfingrip.diagnosis.finger.simulation import FingerSimulation, same_material
from dolfingrip.diagnosis.finger.unknowns import WALLS
from dolfingrip.diagnosis.policy import MODEL, POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL, wall
from dolfingrip.extensions.effect import Prior


def errors(simulation: FingerSimulation) -> Errors:
    """Return the errors of a finger's readings, and of coupons beside it, with their covariance.

    Args:
        simulation: of the model without causes.
    """
    fitted = {MODULUS, WALL} if simulation.walls else {MODULUS}
    shared = [
        replace(each, change=np.nan_to_num(each.change))
        for each in simulation.nuisances
        if each.name not in fitted
    ]
    base = simulation.base
    columns = np.nan_to_num(simulation.mesh.T)
    slope = np.nan_to_num(base.by_control)
    return errors_of(simulation, base.readings, slope, lambda factor: shared, columns)


def wall_std(simulation: FingerSimulation) -> float:
    """Relative standard deviation of the walls; 0 where they are a linear nuisance."""
    if not simulation.walls:
        return 0.0
    return min(t.setup.nuisances[WALL] for t in simulation.measurement.tests)


def baseline_problem(simulation: FingerSimulation, off: Errors) -> InferenceProblem:
    """The problem without causes, whose baseline is the model at any moduli and walls."""
    measurement = simulation.measurement
    listed = measurement.listed()
    n = len(listed)
    std = max(t.setup.nuisances["modulus"] for t in measurement.tests)
    free = same_material(measurement, simulation.config) and std > 0
    std = std if free else 1e-6
    ends = np.log(simulation.centre) + np.log(POLICY.stiffest) * np.array([-1.0, 1.0])
    ends = ends / std if free else np.array([-1.0, 1.0])
    factor = Factor.of(std, *map(float, ends))
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
    every = SimulatedChanges(zeta, told_values, slopes, nodes)
    takes = tuple(range(1 + len(own)))
    baseline = trained_on(every, own, off.noise, takes, share=1.0, left_out=())
    always = [factor_of_moduli(factor, (MODULUS,) if free else ())]
    if spread:
        key, wall_mm = wall(simulation.applied)
        prior, reach = Prior(wall_mm, wall_mm * spread, "as reported"), POLICY.walls_reach
        always.append(Unknown(key, prior, -reach, reach, role="always", names=(WALLS,)))
    return InferenceProblem(
        listed["value"].to_numpy(), simulation.base.readings, tuple(always), {},
        off.covariance, kernel(off.along), {}, baseline,
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


def fitted_moduli(plain: InferenceProblem, known: float, slack: float) -> float:
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


def fitted_walls(plain: InferenceProblem) -> float:
    """The fitted thickness of the walls by that configured, in few steps."""
    prior = plain.always[1].prior
    walls = prior.at(float(_fitted(plain)[1])) / prior.at(0.0)
    step = MODEL.walls_by / 2
    return float(np.round(step * np.round(walls / step), 9))


def plain_fit(plain: InferenceProblem, level: CovarianceModel) -> MapFit:
    """The fit of the model without causes, under one discrepancy; its numbers may be far off."""
    rest = np.zeros(plain.nuisance_count - 1)
    return level.of(tuple(plain.implausible)).fit([np.r_[start, rest] for start in POLICY.starts])


def _fitted(plain: InferenceProblem) -> np.ndarray:
    """ζ under whichever discrepancy the model without causes needs."""
    fits = [plain_fit(plain, CovarianceModel(plain, level)) for level in levels()]
    return max(fits, key=lambda fit: fit.log_evidence).zeta

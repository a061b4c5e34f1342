"""The model of fingers without causes: any moduli, any walls that are fitted, and all errors.

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
from dolfingrip.diagnosis.answer.errors import Errors, errors_of, kernel
from dolfingrip.diagnosis.core.emulator import Coordinate, SimulatedChanges, trained_on
from dolfingrip.diagnosis.core.evidence import CovarianceModel, InferenceProblem, MapFit
from dolfingrip.diagnosis.core.search import at_levels
from dolfingrip.diagnosis.core.unknown import MODULUS, Factor, Unknown, factor_of_moduli
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.simulation import FingerSimulation, coarser
from dolfingrip.diagnosis.finger.unknowns import WALLS
from dolfingrip.diagnosis.policy import MODEL, POLICY, ROUTES
from dolfingrip.diagnosis.simulation.nuisances import wall
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.extensions.effect import Prior
from dolfingrip.parameter import moduli
from dolfingrip.parameter.nuisances import WALL


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
    applied = [test.setup.applied(simulation.config) for test in measurement.tests]
    # one factor changes the moduli of one material
    free = len({str(moduli(each)) for each in applied}) == 1 and std > 0
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
    baseline = trained_on(every, own, off.noise, share=1.0, left_out=())
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
    fits = [plain_fit(plain, level) for level in at_levels(plain).values()]
    return max(fits, key=lambda fit: fit.log_evidence).zeta


def first_pass(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    say: Callable[[str], None] = lambda text: None,
) -> FingerSimulation:
    """The model on the coarsest mesh that bears the load, with moduli that follow the readings.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    say("simulating the measurement as configured")
    found: list[FingerSimulation] = []
    for mesh in coarser(config):
        told = FingerSimulation(
            measurement, config, workers, mesh, found[-1].centre if found else 1.0
        )
        for _ in range(POLICY.passes):
            reached = np.isfinite(told.base_at(told.centre))
            plain = baseline_problem(told, errors(told)).rows(reached)
            # walls are not fitted yet: they may take their part
            centre = fitted_moduli(plain, told.centre, POLICY.recentred)
            if centre == told.centre:
                break
            say(f"the moduli are about {centre:.2g} times those configured; simulating there")
            told = replace(told, centre=centre)
        told = truncate_before_failure(told)
        if found and _reached(told) <= _reached(found[-1]):
            break
        found.append(told)
        if _reached(told) == len(told.plain.readings):
            break
    return found[-1]


def refine_until_consistent(rough: FingerSimulation) -> FingerSimulation:
    """The whole simulation, its causes on a finer mesh where the graded one reads otherwise.

    Args:
        rough: of the first pass.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    every = coarser(rough.config)
    for mesh in every[every.index(rough.flat) :]:
        found = replace(rough, flat=mesh).refined()
        if _off(found) < POLICY.coarse:
            break
    return found


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
    return replace(simulation, headroom=headroom)


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


def model(
    measurement: Measurement, config: Config, workers: Workers, say: Callable[[str], None]
) -> tuple[FingerSimulation, Errors, InferenceProblem]:
    """The model without causes, simulated where its moduli and walls follow the readings."""
    rough = first_pass(measurement, config, workers, say)
    for _ in range(POLICY.passes):
        say("simulating the measurement on a graded mesh")
        simulation = refine_until_consistent(rough)
        off = errors(simulation)
        plain = baseline_problem(simulation, off)
        while (walls := _beyond(simulation, plain)) is not None:
            say(f"the walls are about {walls:.2g} times as thick as configured; simulating there")
            simulation = replace(simulation, tried_walls=(*simulation.tried_walls, walls))
            plain = baseline_problem(simulation, off)
        centre = fitted_moduli(plain, simulation.centre, POLICY.near_enough)
        if centre == simulation.centre:
            break
        say(f"the moduli are about {centre:.2g} times those configured; simulating there")
        other = replace(rough, flat=simulation.flat, centre=centre, headroom=ROUTES.headroom)
        rough = truncate_before_failure(other)
    return simulation, off, plain


def _beyond(simulation: FingerSimulation, plain: InferenceProblem) -> float | None:
    """Walls that the readings ask for beyond those that were simulated; None where they do not."""
    known = simulation.walls
    if not known:
        return None
    walls = fitted_walls(plain)
    tried = simulation.tried_walls
    if min(known) <= walls <= max(known) or walls in tried or walls <= 0:
        return None
    return walls

"""The first simulations: the model without causes, then each cause.

Of coupons, which cost nothing, each cause is simulated all over its prior. A finger is simulated
where its own numbers follow the readings (Gauss and Newton's method). There one simulation has the
derivatives by the amplitudes of all causes that are smooth where they do nothing. Any other cause
is simulated once at its ordinary strength, on either side where these differ. A time in which it
relaxes is then no longer than the longest ramp or wait: readings tell little of a longer one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.checks import numbers_read
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.discrepancy import kernel
from dolfingrip.diagnosis.answer.errors import Errors, errors_of
from dolfingrip.diagnosis.answer.refining import extrapolated
from dolfingrip.diagnosis.core.blend import Tangents, places
from dolfingrip.diagnosis.core.fitting import Hypotheses, MapFit
from dolfingrip.diagnosis.core.problem import NONE, InferenceProblem
from dolfingrip.diagnosis.core.unknown import MODULUS, Cause, Unknown, factor_of_moduli
from dolfingrip.diagnosis.coupon import CouponSimulation, in_closed_form
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger import FingerSimulation, Simulator, at_rest, coarser, shown
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings
from dolfingrip.diagnosis.simulation.unknowns import rig_numbers
from dolfingrip.extensions.index import effect
from dolfingrip.jobs.run import Say, silent
from dolfingrip.parameter import moduli


def simulator_of(
    measurement: Measurement, config: Config, workers: Workers, say: Say = silent
) -> Simulator:
    """Simulate the model as configured: coupons in closed form, others by requests.

    Fingers are simulated on the coarsest mesh that bears the load; readings that none reaches are
    left out.

    Args:
        measurement: the readings.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        say: told what is being done.

    Raises:
        ConfigError: one line, where nothing can be simulated.
    """
    if in_closed_form(measurement, config):
        coupons = CouponSimulation(measurement, config)
        if not np.isfinite(coupons.configured).all():
            raise ConfigError(
                "coupons: the configured material has no equilibrium at some reading; allowed: a "
                "smaller coupon.max_strain, or another material"
            )
        return coupons
    say("simulating the measurement as configured")
    best: FingerSimulation | None = None
    for mesh in coarser(config):
        simulation = FingerSimulation(measurement, config, workers, mesh, graded=False)
        if best is None or _count(simulation.first) > _count(best.first):
            best = simulation
        if _count(simulation.first) == len(simulation.first.readings):
            break
    assert best is not None
    return within_reach(best)


def within_reach(simulation: FingerSimulation) -> FingerSimulation:
    """Leave out readings that the model does not come to at its start.

    Args:
        simulation: of everything that was measured.

    Raises:
        ConfigError: one line, where a test has no reading left.
    """
    measurement, simulated = simulation.measurement, simulation.first
    reached = np.isfinite(simulated.readings)
    lost = not_reached(measurement, reached, simulated)
    if not lost:
        return replace(simulation, whole=None, not_reached=())
    kept = np.where(reached, measurement.listed["value"], np.nan)
    return replace(
        simulation, measurement=measurement.reading(kept), whole=measurement, not_reached=lost
    )


def analyse(
    simulation: Simulator,
    causes: Sequence[Cause],
    names: Sequence[str] | None = None,
    say: Say = silent,
    *,
    quick: bool = False,
) -> Analysis:
    """Simulate the model where it follows the readings, and what causes change.

    Args:
        simulation: of the model as configured.
        causes: that are tried.
        names: of those and of numbers of the rig; everything where None.
        say: told what is being done.
        quick: leave out causes of a finger that need simulations of their own.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    followed: tuple[Simulator, Errors, InferenceProblem, Point]
    if isinstance(simulation, CouponSimulation):
        left, followed = [], _stretched(simulation)
    else:
        left = [c.name for c in causes if quick and not (c.smooth or shown(c))]
        numbers = rig_numbers(simulation.measurement, simulation.config, names)
        followed = _followed(simulation, *numbers, say)
    model, off, problem, start = followed
    causes = [cause for cause in causes if cause.name not in left]
    say(f"simulating what {len(causes)} causes change")
    runs, failed = _first(model, causes, start, off.noise)
    by_name = {cause.name: cause for cause in causes}
    felt = {name: by_name[name] for name in runs}
    displaying = {n for n, cause in felt.items() if shown(cause) and not model.closed_form}
    numbers_of = {name: cause.numbers for name, cause in felt.items()}
    problem = replace(problem, numbers=numbers_of, displaying=frozenset(displaying))
    problem = problem.beside(((name,), run) for name, run in runs.items())
    unseen = tuple(name for name in by_name if name not in {*runs, *failed})
    return Analysis(problem, felt, off, model, unseen, failed, left)


def _stretched(
    simulation: CouponSimulation,
) -> tuple[CouponSimulation, Errors, InferenceProblem, Point]:
    """Coupons without causes as configured: their moduli scale exactly."""
    policy = simulation.measurement.policy
    setups = [test.setup.nuisances for test in simulation.measurement.tests]
    std = float(max(np.hypot(setup["modulus"], setup["coupon_area"]) for setup in setups))
    reach = float(np.log(1000) / max(std, 0.01))
    start = Point(factor_of_moduli(std, -reach, reach, (MODULUS, "coupon_area")), 0.0)
    errors = errors_of(simulation)
    reach, least = policy.reach, policy.invisible * errors.noise
    seen = tuple(number for number in errors.rig if (np.abs(number.change) > least).any())
    linear = [
        replace(n.unknown, low=-reach, high=reach, role="always", names=(n.name,)) for n in seen
    ]
    errors, runs = replace(errors, rig=seen), [simulation.plain(start)]
    problem = _problem(simulation, errors, (start.factor,), linear, runs)
    return simulation, errors, problem, start


def _count(simulated: SimulatedReadings) -> int:
    return int(np.isfinite(simulated.readings).sum())


def not_reached(
    measurement: Measurement, reached: np.ndarray, simulated: SimulatedReadings
) -> list[str]:
    """For each test, readings that the model does not come to, and why.

    Args:
        measurement: all that was measured.
        reached: which of its readings are, (n,) of bool.
        simulated: the model as configured.

    Raises:
        ConfigError: one line, where a test has none left.
    """
    every, lines = measurement.listed["test"].to_numpy(), []
    for test in measurement.tests:
        mine = every == test.number
        ended = (run.why for run in simulated.failures if test.number in run.group.tests)
        why = "; ".join(filter(None, ended))
        who = f"{test.experiment} of {test.specimen}: the base simulation"
        count, left = int(mine.sum()), int((mine & reached).sum())
        if not left:
            raise ConfigError(f"{who} reaches no reading: {why}")
        if left < count:
            lost = count - left
            lines.append(
                f"{who} does not reach {lost} of {count} readings, which are left out: {why}"
            )
    return lines


def _followed(
    simulation: FingerSimulation, solid: Sequence[Unknown], linear: Sequence[Unknown], say: Say
) -> tuple[FingerSimulation, Errors, InferenceProblem, Point]:
    """The model without causes at the numbers that follow the readings, on both meshes."""
    factor, policy = _factor(simulation), simulation.measurement.policy
    start = simulation.start or Point(factor, 0.0, tuple((n, 0.0) for n in solid))
    simulation, runs = replace(simulation, start=start), list[Tangents]()
    for _ in range(policy.tries):
        plain = simulation.plain(start)
        if not np.isfinite(plain.told).all():
            break
        runs.append(plain)
        problem = _problem(simulation, errors_of(simulation), (factor, *solid), linear, runs)
        fit = _best(problem)
        if extrapolated(problem, fit) <= policy.exactly:
            break
        start = Point.of((factor, *solid), fit.zeta)
        say(f"the moduli are about {start.moduli:.3g} times those configured; simulating there")
        simulation = replace(simulation, start=start)
    if len(runs) and not np.isfinite(plain.told).all():
        # numbers at which a finger ends before its readings are excluded by these
        numbers = factor, *solid
        zeta = [n.zeta_of(float(u)) for n, u in zip(numbers, runs[-1].u[0], strict=True)]
        start = Point.of(numbers, zeta)
        simulation = replace(simulation, start=start)
    if not runs:
        raise ConfigError("the base simulation does not reach the readings with its own numbers")
    if simulation.whole is not None:
        # with numbers that follow the readings the model may go on where it ended as configured
        farther = within_reach(replace(simulation, measurement=simulation.whole))
        if len(farther.first.readings) > len(simulation.first.readings):
            say("simulating readings that the model reaches with these numbers")
            return _followed(farther, solid, linear, say)
    slower = simulation.in_shorter_steps if simulation.shorter else simulation
    change = (slower.first.readings - simulation.first.readings) / errors_of(simulation).noise
    if np.linalg.norm(np.nan_to_num(change)) > policy.visible:
        say("simulating all in shorter steps, as what these change could be seen")
        simulation, runs = slower, [slower.plain(start)]
    say("simulating the measurement on a graded mesh")
    graded = replace(simulation, graded=True)
    if graded.has_coarser and not np.isfinite(graded.fine.readings).all():
        graded = replace(simulation, flat={})
        runs = [graded.plain(start)]
    elif graded.has_coarser and _off(graded) > policy.part:
        every = coarser(graded.config)
        finer = every[min(every.index(graded.flat) + 1, len(every) - 1)]
        graded = replace(graded, flat=finer)
        runs = [graded.plain(start)]
    else:
        shifted = [run.told.copy() for run in runs]
        for columns in shifted:
            columns[..., 0] += graded.delta
        runs = [Tangents(run.u, columns) for run, columns in zip(runs, shifted, strict=True)]
    errors = errors_of(graded)
    problem = _problem(graded, errors, (factor, *solid), linear, runs)
    return graded, errors, problem, start


def _off(simulation: FingerSimulation) -> float:
    """Largest difference of a channel between both meshes, by its size; root mean squares."""
    rms = simulation.measurement.rms
    sizes, off = rms(simulation.fine.readings), rms(simulation.delta)
    return max(off[name] / size if size else 0.0 for name, size in sizes.items())


def _factor(simulation: FingerSimulation) -> Unknown:
    measurement = simulation.measurement
    std = max(t.setup.nuisances["modulus"] for t in measurement.tests)
    # one factor changes the moduli of one material
    applied = measurement.applied(simulation.config)
    free = len({str(moduli(config)) for config in applied}) == 1 and std > 0
    reach = float(np.log(measurement.policy.stiffest) / std) if free else 1.0
    return factor_of_moduli(std if free else 1e-6, -reach, reach, (MODULUS,) if free else ())


def _problem(
    simulation: Simulator,
    errors: Errors,
    solid: Sequence[Unknown],
    linear: Sequence[Unknown],
    runs: Sequence[Tangents],
) -> InferenceProblem:
    """The problem without causes.

    Args:
        simulation: of the model.
        errors: with all numbers of the rig.
        solid: numbers that simulations are made at.
        linear: numbers that readings are linear in, and that may be far from what was told.
        runs: simulations.
    """
    far, solid_names = {n.told_as: n for n in linear}, {n.told_as for n in solid}
    rig = [number for number in errors.rig if number.name not in solid_names]
    seen = [far.get(number.name, number.unknown) for number in rig]
    columns = [number.change for number in rig]
    value = simulation.measurement.listed["value"].to_numpy()
    problem = InferenceProblem(
        value, np.nan_to_num(simulation.configured), errors.noise, (*solid, *seen),
        np.column_stack([np.zeros((len(value), 0)), *columns]), {}, errors.covariance,
        kernel(errors.along), told=numbers_read(simulation.measurement, simulation.config),
        policy=simulation.measurement.policy,
    )  # fmt: skip
    return problem.beside([(NONE, Tangents.stacked(runs))])


def _best(problem: InferenceProblem) -> MapFit:
    """The fit without causes under whichever discrepancy it needs; its numbers may be far off."""
    names, start = tuple(problem.implausible), np.zeros(problem.nuisance_count)
    fits = Hypotheses(problem, [names]).fits({(names, level): [start] for level in problem.levels})
    return max(fits, key=lambda fit: fit.log_evidence + np.log(problem.policy.levels[fit.level]))


def _first(
    simulation: Simulator, causes: Sequence[Cause], start: Point, noise: np.ndarray
) -> tuple[Mapping[str, Tangents], Mapping[str, str]]:
    """Simulations of each cause that some reading feels; and why others could not be made."""
    base, policy = simulation.plain(start), simulation.measurement.policy
    smooth = [c for c in causes if c.smooth]
    resting = simulation.resting(smooth, start) if smooth else {}
    runs, failed, points = {**(resting or {})}, dict[str, str](), dict[str, list[Point]]()
    # one of them may not let the others be simulated
    left = [cause for cause in causes if resting is None or not cause.smooth]
    left = [c for c in left if any(g.feels(f"extensions.{c.name}") for g in simulation.groups)]
    legs = simulation.measurement.readings.groupby(["test", "leg"])["time_s"]
    longest_s = float((legs.max() - legs.min()).max()) or np.inf
    for cause in left:
        box, d = cause.box(), len(cause.numbers)
        count = policy.training[min(d, len(policy.training)) - 1]
        if simulation.closed_form:
            every = places(box, count)
        elif shown(cause):
            near = np.clip(box, -policy.reach, policy.reach)
            every = np.vstack([places(near, count), places(box, count)])
        else:
            signs = (1.0, -1.0) if effect(cause.name).lopsided else (1.0,)
            every = np.array([cause.at_strength(sign, longest_s, policy.start) for sign in signs])
        points[cause.name] = [replace(start, causes=((cause, zeta),)) for zeta in every]
    simulated = iter(simulation.at([point for several in points.values() for point in several]))
    for cause in left:
        all_over = simulation.closed_form or shown(cause)
        least = 2 * len(cause.numbers) + 2 if all_over else 1
        tangents = [run for run in islice(simulated, len(points[cause.name])) if run is not None]
        if len(tangents) < least:
            failed[cause.name] = "its simulation does not reach all readings"
            continue
        first = [] if all_over else [_at_rest(cause, base, tangents[0])]
        runs[cause.name] = Tangents.stacked([*first, *tangents])
    return {
        name: run for name, run in runs.items() if _felt(run, base, noise, policy.invisible)
    }, failed


def _at_rest(cause: Cause, base: Tangents, run: Tangents) -> Tangents:
    """Where a cause does nothing, with the secant to a simulation of it in place of derivatives."""
    off = [
        u - cause.resting_coordinate(number) if number.amplitude else 0.0
        for u, number in zip(run.u[0, base.u.shape[1] :], cause.numbers, strict=True)
    ]
    change = run.told[0, :, 0] - base.told[0, :, 0]
    return at_rest(cause, base, np.outer(change, np.array(off) / max(np.dot(off, off), 1e-12)))


def _felt(run: Tangents, base: Tangents, noise: np.ndarray, least: float) -> bool:
    """Tell whether some reading feels a cause by a standard deviation of its numbers."""
    changes = (run.told[..., 0] - base.told[..., 0]) / noise
    slopes = run.told[:, :, 1 + base.u.shape[1] :] / noise[:, None]
    most = [
        np.sqrt(np.square(sizes).mean(axis=1)).max()
        for sizes in (changes, np.moveaxis(slopes, 2, 1).reshape(-1, len(noise)))
    ]
    return bool(max(most) > least)

"""Nuisances that are not linear: gap and regulator's zero, where they move the first contact.

Before the tip touches there is no force, behind it there is one: at readings between the contact
as told and the contact as it was, a derivative is wrong by its whole. Where the nuisances that fit
best move the contact past readings, gap and zero become parameters of every fit, and are simulated
at their values like the modulus. Else they are linear, which costs nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from dolfingrip.channels import FORCE
from dolfingrip.diagnosis.conclude import Conclusion
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.linear import with_linear
from dolfingrip.diagnosis.model import FreeParameter
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.nuisances import GAP, OFFSET
from dolfingrip.extensions.effect import Prior

FARTHEST: Final = 2.5
"""Standard deviations of a nuisance that are believed at most: beyond, something else is wrong."""

NOTICED: Final = 0.5
"""By how much a derivative has to be wrong to matter, in standard deviations of the noise."""

SHIFTS: Final = frozenset({"pressure_offset_kPa", "plate_gap_mm"})
"""Nuisances that move the contact."""

HIGHEST_kPa: Final = 100.0

GRID: Final = 12
"""Places of a nuisance to either side, where a fit looks for its start."""


def needed(problem: Problem, conclusion: Conclusion, none: Hypothesis) -> bool:
    """Whether the contact moves past readings, so that derivatives are wrong there.

    Near its beginning a force moves along the pressure, by Δp = −(∂F/∂z z)/(∂F/∂p).
    """
    force = _blocked_forces(problem)
    sizes = _fitted(problem, _most_probable(problem, conclusion, none))
    if problem.shifts or not force.any() or not parameters(problem) or not any(sizes.values()):
        return False
    pressure, simulated = problem.index["pressure_kPa"].to_numpy()[force], problem.simulated[force]
    noise = problem.noise_std[force]
    change = _linear(problem, sizes)[force]
    slope = problem.take(problem.base.by_control)[force]
    order = np.argsort(pressure)
    curve_kPa, at = np.unique(pressure[order], return_index=True)
    curve = simulated[order][at]
    touching = np.flatnonzero(simulated > NOTICED * noise)
    if not touching.size or len(curve_kPa) < 2:
        return False
    first = touching[pressure[touching].argmin()]
    steepest = max(float(slope[touching].max()), 1e-12)
    shift_kPa = -float(change[touching][np.abs(change[touching]).argmax()]) / steepest
    exact = np.interp(pressure - shift_kPa, curve_kPa, curve)
    near = np.abs(pressure - pressure[first]) <= 2 * abs(shift_kPa) + 1e-9
    wrong = np.abs(exact - simulated - change) > NOTICED * noise
    return bool((near & wrong).any())


def with_shifts(problem: Problem) -> Problem:
    """The same readings, gap and regulator's zero among what fits find."""
    return replace(problem, shifts=tuple(parameters(problem)))


def parameters(problem: Problem) -> list[FreeParameter]:
    """Gap and zero as parameters; none where tests have several gaps, or the zero is an effect."""
    base, tests = problem.base, problem.measurement.tests
    blocked = [test for test in tests if test.experiment == "blocked_force"]
    gaps = {test.setup.applied(base.config).plate.gap_mm for test in blocked}
    files = {test.file for test in blocked}
    if len(gaps) != 1 or len(files) != 1 or not base.scales or problem.scale is None:
        return []
    (gap_mm,) = gaps
    spreads = tests[0].setup.nuisances
    found = []
    if spreads["plate_gap_mm"]:
        prior = Prior(gap_mm, spreads["plate_gap_mm"], "of the plate's place")
        found.append(FreeParameter(GAP, prior, 0.0, np.inf))
    on = base.config.extensions.active()
    if spreads["pressure_offset_kPa"] and not any(e.name() == "pressure_offset" for e in on):
        prior = Prior(0.0, spreads["pressure_offset_kPa"], "of the regulator's zero")
        found.append(FreeParameter(OFFSET, prior, -HIGHEST_kPa, HIGHEST_kPa))
    return found


def start(problem: Problem) -> dict[str, float]:
    """Modulus and gap to start from, by key: the best on a grid.

    The force's curve is moved along the pressure, by Δp = −(∂F/∂gap)/(∂F/∂p) for each mm; the least
    squares of simulations alone would not find over the kink.
    """
    base, force = problem.base, _blocked_forces(problem)
    by_gap = problem.take(base.simulated.slope(GAP))[force]
    slope = problem.take(base.by_control)[force]
    run = next(run for run in base.simulated.runs if run.group.experiment == "blocked_force")
    curve_kPa = np.array(run.route.value)[: len(run.result.columns[FORCE.name])]
    curve_N = run.result.columns[FORCE.name]
    steepest = int(np.abs(by_gap).argmax())
    by_mm = float(by_gap[steepest]) / max(float(slope[steepest]), 1e-12)
    pressure = problem.index["pressure_kPa"].to_numpy(dtype=float)[force]
    own = {p.key: p for p in problem.shifts}
    assert problem.scale is not None
    every = [each for each in (problem.scale, problem.wall, *problem.shifts) if each is not None]
    best, found = np.inf, {each.key: each.prior.mean for each in every}
    if GAP not in own:
        return found
    for z in np.linspace(-FARTHEST, FARTHEST, 2 * GRID + 1):
        for zeta in np.linspace(-FARTHEST, FARTHEST, 2 * GRID + 1):
            gap_mm = own[GAP].prior.mean + z * own[GAP].prior.spread
            factor = problem.scale.prior.at(float(zeta))
            if gap_mm < 0:
                continue
            moved_kPa = pressure / factor + by_mm * (gap_mm - own[GAP].prior.mean)
            readings = problem.take(base.at_modulus(factor))
            readings[force] = factor * _on(curve_kPa, curve_N, moved_kPa)
            left = problem.covariance.whiten(problem.value - readings)
            cost = float(left @ left) + z**2 + zeta**2
            if cost < best:
                best = cost
                found[problem.scale.key], found[GAP] = factor, gap_mm
    return found


def _blocked_forces(problem: Problem) -> np.ndarray:
    """Which readings are forces of a blocked finger, shape (n,) of bool."""
    index = problem.index
    found = (index["channel"] == FORCE.name) & (index["experiment"] == "blocked_force")
    return np.asarray(found.to_numpy())


def _on(curve_kPa: Vector, curve_N: Vector, at_kPa: Vector) -> Vector:
    """Force on a curve; 0 before it, and along a straight line behind it."""
    steepness = (curve_N[-1] - curve_N[-2]) / (curve_kPa[-1] - curve_kPa[-2])
    beyond = np.maximum(at_kPa - curve_kPa[-1], 0.0)
    return np.asarray(np.interp(at_kPa, curve_kPa, curve_N) + steepness * beyond)


def _most_probable(problem: Problem, conclusion: Conclusion, none: Hypothesis) -> Hypothesis:
    """Of none and the single effects, by the screen."""
    alone = conclusion.posterior.singles + conclusion.posterior.beside
    if not len(alone) or conclusion.posterior.none >= alone.max():
        return none
    score = conclusion.scores[int(alone.argmax())]
    candidate = next(each for each in problem.base.candidates if each.name == score.name)
    return with_linear(problem, (score.name,), none, [(score, candidate)])


def _fitted(problem: Problem, fit: Hypothesis) -> dict[str, float]:
    """What moves the contact beside a fit, in standard deviations."""
    return {
        name: min(max(z, -FARTHEST), FARTHEST)
        for name, z in fit.fitted_nuisances(problem).items()
        if name in SHIFTS
    }


def _linear(problem: Problem, sizes: Mapping[str, float]) -> Vector:
    found = np.zeros(len(problem.value))
    for each in problem.linear_nuisances():
        found += sizes.get(each.name, 0.0) * each.change
    return found

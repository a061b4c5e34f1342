"""Models without a cause, refitted as well as they can be: what a cause has to beat.

The base model with its nuisances: the modulus by exact scaling and from several starts. As no
nuisance explains what a strong effect does, what is left is far above the noise; so the noise is
taken as many times larger as makes the readings that are known most probable, lest the fit chase
the most precise column at the cost of the others. And the base model with a Gaussian process.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.laplace import to_zeta
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.step import hypothesis_at, visit

FACTORS: Final = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Of the modulus of the fit to all readings: where a refit starts."""

LARGER: Final = tuple(float(4**k) for k in range(6))
"""Of the standard deviation of the noise: what is tried."""

STEPS: Final = 6
"""Of Gauss and Newton from each start."""


def refitted(problem: Problem, none: Hypothesis, known: np.ndarray) -> Vector:
    """All readings, shape (n,), by the base model fitted to those ``known``, shape (n,) of bool."""
    found = []
    for larger in LARGER:
        own = _noisier(problem, larger)
        fit = _sought(own, none, known)
        found.append((_log_density(own, fit, known), own, fit))
    _, own, fit = max(found, key=lambda each: each[0])
    return fit.predicted(own, known)


def with_process(
    problem: Problem, none: Hypothesis, smooth: SmoothMisfit, known: np.ndarray
) -> Vector:
    """The base model with the process that explains the known readings best."""
    best, value = None, -np.inf
    noise = problem.error_covariance.matrix[np.ix_(known, known)]
    own = np.hstack([none.jacobian, problem.nuisances])
    residual = none.residual(problem.value)[known]
    factor = none.covariance(problem).factor
    for system in smooth.systems:
        # U √Λ are the whitened features; unwhitened they are the process at the size 1
        features = factor @ (system.vectors * np.sqrt(system.values))
        for size in smooth.sizes[::2]:
            seen = np.hstack([own, size * features])[known]
            density = Covariance.of(noise + seen @ seen.T).log_density(residual)
            if density > value:
                best, value = size * features, density
    others: list[Matrix] = [] if best is None else [best]
    return none.predicted(problem, known, others)


def _noisier(problem: Problem, larger: float) -> Problem:
    if larger == 1.0:
        return problem
    return problem.with_noise({key: each.scaled(larger) for key, each in problem.noise.items()})


def _log_density(problem: Problem, fit: Hypothesis, known: np.ndarray) -> float:
    """Of the known readings, about a fit."""
    columns = np.hstack([fit.jacobian, problem.nuisances])[known]
    noise = problem.error_covariance.matrix[np.ix_(known, known)]
    return Covariance.of(noise + columns @ columns.T).log_density(
        fit.residual(problem.value)[known]
    )


def _sought(problem: Problem, none: Hypothesis, known: np.ndarray) -> Hypothesis:
    """The base model at the modulus that fits the known readings best."""
    if none.model is None or len(none.parameters) != 1:
        return none
    columns = problem.nuisances[known]
    noise = problem.error_covariance.matrix[np.ix_(known, known)]
    covariance = Covariance.of(noise + columns @ columns.T)
    (parameter,) = none.parameters
    found = []
    for by in FACTORS:
        value = min(max(none.values[0] * by, parameter.low), parameter.high)
        zeta = np.array([to_zeta(parameter.prior, value)])
        for _ in range(STEPS):
            here = _base(problem, none, zeta)
            white = covariance.whiten(
                np.column_stack([here.residual(problem.value), here.jacobian])[known]
            )
            best = float(white[:, 1] @ white[:, 0]) / (1 + float(white[:, 1] @ white[:, 1]))
            ends = [to_zeta(parameter.prior, v) for v in (parameter.low, parameter.high)]
            zeta = np.array([min(max(best, ends[0]), ends[1])])
        here = _base(problem, none, zeta)
        left = covariance.whiten((problem.value - here.readings)[known])
        found.append((float(left @ left + zeta @ zeta), here))
    return min(found, key=lambda each: each[0])[1]


def _base(problem: Problem, none: Hypothesis, zeta: Vector) -> Hypothesis:
    assert none.model is not None
    return hypothesis_at((), none.model, visit(problem, none.model.evaluate, none.model, zeta))

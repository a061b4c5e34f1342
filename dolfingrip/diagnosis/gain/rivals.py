"""Models without a cause, refitted as well as they can be: what a cause has to beat.

The base model with its nuisances: the modulus by exact scaling, the best of its whole range. As no
nuisance explains what a strong effect does, what is left is far above the noise; so the noise is
taken as many times larger as makes the readings that are known most probable, lest the fit chase
the most precise column at the cost of the others. And the base model with a Gaussian process.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from dolfingrip.diagnosis.gain.refitted import Refitted
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit
from dolfingrip.diagnosis.problem import Problem

RANGE: Final = 2.5
"""Of the modulus about that of the fit to all readings, to either side: a factor."""

PLACES: Final = 41
"""Moduli that the base model is scaled to."""

LARGER: Final = tuple(float(4**k) for k in range(6))
"""Of the standard deviation of the noise: what is tried."""


class NuisanceFit:
    """The base model with its nuisances, to be fitted to any part of the readings.

    Args:
        problem: the readings.
        none: the base model's fit to all of them.
    """

    def __init__(self, problem: Problem, none: Hypothesis) -> None:
        self._none = none
        self._problems = [
            problem.with_noise({key: each.scaled(larger) for key, each in problem.noise.items()})
            for larger in LARGER
        ]
        self._zeta: Vector = np.zeros(0)
        model = none.model
        if model is None or len(none.parameters) != 1 or model.base is None:
            return
        (parameter,) = none.parameters
        ends = (none.values[0] / RANGE, none.values[0] * RANGE)
        low, high = (parameter.prior.zeta(min(max(end, parameter.low), parameter.high))
                     for end in ends)  # fmt: skip
        self._zeta = np.asarray(np.linspace(low, high, PLACES), dtype=float)
        rows = [problem.take(model.evaluate([parameter.prior.at(float(z))])[0]) for z in self._zeta]
        self._curve = CubicSpline(self._zeta, np.array(rows))

    def refitted(self, known: np.ndarray) -> Refitted:
        """Fitted to the readings ``known``, shape (n,) of bool."""
        best, chosen = -np.inf, (self._problems[0], self._none)
        for problem in self._problems:
            columns = np.hstack([self._none.jacobian, problem.nuisances])[known]
            noise = problem.error_covariance.matrix[np.ix_(known, known)]
            fit = self._sought(problem, noise, known)
            density = Covariance.of(noise + columns @ columns.T).log_density(
                fit.residual(problem.value)[known]
            )
            if density > best:
                best, chosen = density, (problem, fit)
        return Refitted.of(*chosen, known)

    def _sought(self, problem: Problem, noise: Matrix, known: np.ndarray) -> Hypothesis:
        """At the modulus that fits the known readings best."""
        if not self._zeta.size:
            return self._none
        columns = problem.nuisances[known]
        covariance = Covariance.of(noise + columns @ columns.T)

        def cost(zeta: float) -> float:
            left = covariance.whiten((problem.value - self._curve(zeta))[known])
            return float(left @ left) + zeta**2

        left = covariance.whiten((problem.value - self._curve(self._zeta))[:, known].T)
        costs = (left**2).sum(axis=0) + self._zeta**2
        at = int(np.argmin(costs))
        ends = self._zeta[max(at - 1, 0)], self._zeta[min(at + 1, PLACES - 1)]
        zeta = float(minimize_scalar(cost, bounds=ends, method="bounded").x)
        return replace(
            self._none, zeta=np.array([zeta]), readings=np.asarray(self._curve(zeta)),
            jacobian=np.asarray(self._curve(zeta, 1))[:, None],
        )  # fmt: skip


def with_process(
    problem: Problem, none: Hypothesis, smooth: SmoothMisfit, known: np.ndarray
) -> Refitted:
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
    return Refitted.of(problem, none, known, others)

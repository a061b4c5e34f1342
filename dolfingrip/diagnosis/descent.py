"""Least squares that count simulations: scipy's, ended where the next step would tell nothing.

Each evaluation is a simulation of the whole measurement with its derivatives, so the tangent is at
hand and foretells what the next step gains. A search ends where that is little, along the tangent;
or where even so the hypothesis stays far behind one that is fitted already.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.laplace import MARGIN, to_values, zeta_bounds
from dolfingrip.diagnosis.model import FitFailure, FreeParameter

SHIFT = 10.0
"""Added to ζ for scipy, whose first step is no longer than the start is from 0."""

TINY = 1e-9
"""Least room for a step, in ζ, where a place is on a bound."""

BAD = 3.0
"""What stands for the readings where a simulation fails: these are off by so many times."""


@dataclass(frozen=True)
class Visited:
    """A place where the readings were simulated.

    Attributes:
        zeta: shape (p,).
        readings: shape (n,).
        jacobian: by ζ, shape (n, p).
    """

    zeta: Vector
    readings: Vector
    jacobian: Matrix


@dataclass
class Descent:
    """How a search went.

    Attributes:
        last: where it ended, the best place of all.
        stepped: ζ of the step from there along the tangent, within bounds; ζ there where the
            search did not end along the tangent.
        hopeless: whether it was given up.
        visited: places with derivatives, in order.
    """

    last: Visited
    stepped: Vector
    hopeless: bool = False
    visited: list[Visited] = field(default_factory=list)

    def curvature(self, covariance: Covariance) -> float:
        """How far readings leave the tangent, σ by the step in σ squared; NaN if unknown.

        Of the longest step: on short ones rounding counts.
        """
        length, found = 0.0, float("nan")
        for before, after in pairwise(self.visited):
            step = after.zeta - before.zeta
            straight = before.jacobian @ step
            own = float(np.linalg.norm(covariance.whiten(straight)))
            if own > length:
                off = covariance.whiten(after.readings - before.readings - straight)
                length, found = own, float(np.linalg.norm(off)) / own**2
        return found


def tangent_step(jac: Matrix, left: Vector, zeta: Vector, low: Vector, high: Vector) -> Vector:
    """The step of Gauss and Newton within bounds: the least |left + jac step|, shape (p,)."""
    free = -np.linalg.lstsq(jac, left, rcond=None)[0]
    if ((zeta + free >= low) & (zeta + free <= high)).all():
        return np.asarray(free)
    # cutting the free step off at a bound would leave the other parameters where they are worse
    lowest, highest = np.minimum(low - zeta, -TINY), np.maximum(high - zeta, TINY)
    return np.clip(lsq_linear(jac, -left, bounds=(lowest, highest)).x, low - zeta, high - zeta)


class _Ended(Exception):
    """The search is over."""


def descend(
    evaluate: Callable[[list[float]], tuple[Vector, Matrix]],
    parameters: Sequence[FreeParameter],
    value: Vector,
    covariance: Covariance,
    start: Sequence[float],
    settled: float,
    most_evaluations: int,
    hopeless: Callable[[Visited, float], bool] | None = None,
    straight: float = 0.0,
) -> Descent:
    """Seek the most probable parameters.

    Args:
        evaluate: readings, shape (n,), and derivatives by the parameters' values, shape (n, p).
        parameters: that are free.
        value: measured, shape (n,).
        covariance: of the residual.
        start: values.
        settled: decrease of half the sum of squares below which a step is not worth a simulation.
        most_evaluations: of ``evaluate``.
        hopeless: told a place and the decrease that its tangent promises, from the second on; where
            true the search is given up.
        straight: ends where the readings will not leave the tangent by more than this, in standard
            deviations, along the step that is left.

    Raises:
        FitFailure: where the first simulation fails.
    """
    priors = [p.prior for p in parameters]
    low, high = zeta_bounds(priors, [(p.low, p.high) for p in parameters])
    visited: list[Visited] = []
    ended = Descent(Visited(np.zeros(0), value, np.zeros((len(value), 0))), np.zeros(0))

    def misfit(shifted: Vector) -> Vector:
        zeta = shifted - SHIFT
        try:
            readings, _ = evaluate(to_values(priors, zeta))
        except FitFailure:
            if not visited:
                raise
            return np.concatenate([BAD * covariance.whiten(value), zeta])
        return np.concatenate([covariance.whiten(value - readings), zeta])

    def slopes(shifted: Vector) -> Matrix:
        zeta = shifted - SHIFT
        readings, by_value = evaluate(to_values(priors, zeta))
        factors = np.array([p.slope(float(z)) for p, z in zip(priors, zeta, strict=True)])
        here = Visited(zeta, readings, by_value * factors)
        visited.append(here)
        white = covariance.whiten(np.column_stack([value - readings, here.jacobian]))
        left = np.concatenate([white[:, 0], zeta])
        jac = np.vstack([-white[:, 1:], np.eye(len(zeta))])
        step = tangent_step(jac, left, zeta, low, high)
        gain = 0.5 * float(left @ left - np.sum((left + jac @ step) ** 2))
        ended.last, ended.stepped, ended.visited = here, zeta + step, visited
        length = float(np.linalg.norm(white[:, 1:] @ step))
        if gain < settled or ended.curvature(covariance) * length**2 < straight:
            raise _Ended
        if hopeless is not None and len(visited) > 1 and hopeless(here, gain):
            ended.hopeless = True
            raise _Ended
        return jac

    first = np.array([p.zeta(v) for p, v in zip(priors, start, strict=True)])
    with suppress(_Ended):
        least_squares(
            misfit, np.clip(first, low + MARGIN, high - MARGIN) + SHIFT, jac=slopes,
            bounds=(low + SHIFT, high + SHIFT), max_nfev=most_evaluations, xtol=1e-5, ftol=1e-4,
        )  # fmt: skip
        # where shorter and shorter steps were needed, the tangent's whole step is none
        ended.stepped = ended.last.zeta
    return ended

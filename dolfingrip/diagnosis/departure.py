"""How far readings leave their tangent along a step: whether it needs another simulation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from dolfingrip.diagnosis.descent import Descent
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.laplace import to_values
from dolfingrip.diagnosis.model import EffectModel
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.surface import SecantSurface

Departure = Callable[[Hypothesis, Hypothesis], float]
"""Of all readings together, in standard deviations, from a place along its tangent to another."""

PART: Final = 1e-3
"""Part of a step over which a surface is derived along it."""


def by_descent(problem: Problem, found: Descent) -> Departure:
    """By the curvature on the way that a search took; NaN where it is not known."""
    curvature = found.curvature(problem.covariance)

    def leaves(before: Hypothesis, after: Hypothesis) -> float:
        step = before.jacobian @ (after.zeta - before.zeta)
        return curvature * float(np.linalg.norm(problem.covariance.whiten(step))) ** 2

    return leaves


def by_surface(problem: Problem, surface: SecantSurface, base: EffectModel) -> Departure:
    """By the surface between the screen's simulations, beside the base model.

    Args:
        problem: the readings.
        surface: of the effect, whose parameters are the last ones.
        base: the model without it, in closed form, of the parameters before these.
    """
    count = len(base.parameters)
    priors = [p.prior for p in base.parameters]

    def readings(zeta: Vector) -> Vector:
        values = to_values(priors, zeta[:count])
        factor = 1.0 if base.scale is None else base.scale.prior.at(float(zeta[0]))
        return problem.take(base.evaluate(values)[0]) + surface.change(zeta[count:], factor)

    def leaves(before: Hypothesis, after: Hypothesis) -> float:
        step = after.zeta - before.zeta
        ahead, behind = (readings(before.zeta + way * PART * step) for way in (1, -1))
        straight = (ahead - behind) / (2 * PART)
        off = readings(after.zeta) - readings(before.zeta) - straight
        return float(np.linalg.norm(problem.covariance.whiten(off)))

    return leaves

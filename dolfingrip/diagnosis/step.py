"""A hypothesis at given parameters, and a step of Gauss and Newton from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dolfingrip.diagnosis.descent import Visited, tangent_step
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.laplace import to_values, zeta_bounds
from dolfingrip.diagnosis.model import EffectModel
from dolfingrip.diagnosis.problem import Problem

Evaluate = Callable[[Sequence[float]], tuple[Vector, Matrix]]
"""Readings of all rows and their derivatives, of values."""


def visit(problem: Problem, evaluate: Evaluate, model: EffectModel, zeta: Vector) -> Visited:
    """The readings that are kept, and their derivatives, at ζ."""
    priors = [p.prior for p in model.parameters]
    readings, slopes = evaluate(to_values(priors, zeta))
    by_zeta = np.array([prior.slope(float(z)) for prior, z in zip(priors, zeta, strict=True)])
    return Visited(zeta, problem.take(readings), slopes[problem.kept] * by_zeta)


def hypothesis_at(names: tuple[str, ...], model: EffectModel, place: Visited) -> Hypothesis:
    """The hypothesis whose readings were computed there."""
    values = to_values((p.prior for p in model.parameters), place.zeta)
    return Hypothesis(
        names, tuple(model.parameters), place.zeta, place.readings, place.jacobian,
        model.count, model, model.overrides(values),
    )  # fmt: skip


def stepped(problem: Problem, fit: Hypothesis) -> Hypothesis:
    """One step of Gauss and Newton along the tangent, within the bounds."""
    white = problem.covariance.whiten(np.column_stack([fit.residual(problem.value), fit.jacobian]))
    low, high = zeta_bounds(
        [p.prior for p in fit.parameters], [(p.low, p.high) for p in fit.parameters]
    )
    jac = np.vstack([-white[:, 1:], np.eye(white.shape[1] - 1)])
    left = np.concatenate([white[:, 0], np.zeros(white.shape[1] - 1)])
    # the residual is that at ζ = 0 along the tangent
    zeta = tangent_step(jac, left, np.zeros(len(low)), low, high)
    values = to_values((p.prior for p in fit.parameters), zeta)
    assert fit.model is not None
    return replace(
        fit, zeta=zeta, readings=fit.readings + fit.jacobian @ (zeta - fit.zeta),
        overrides=fit.model.overrides(values),
    )  # fmt: skip

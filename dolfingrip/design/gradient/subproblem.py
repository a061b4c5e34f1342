"""The best step by a model of a problem, inside the box in which the model is trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Rows:
    """Linear limits c + J s ≤ 0 of a step s, with a bound on what the linear part leaves out.

    Attributes:
        values: shape (m,), c.
        slopes: shape (m, n), J.
        bend: shape (m,): half of it times |s|² is added.
    """

    values: Floats
    slopes: Floats
    bend: Floats

    @classmethod
    def none(cls, n: int) -> Rows:
        """No limit of n variables."""
        return cls(np.empty(0), np.empty((0, n)), np.empty(0))

    def with_rows(self, *others: Rows) -> Rows:
        """All of them."""
        every = (self, *others)
        return Rows(
            np.concatenate([each.values for each in every]),
            np.concatenate([each.slopes for each in every]),
            np.concatenate([each.bend for each in every]),
        )


@dataclass(frozen=True, slots=True)
class Model:
    """Objectives fᵢ + gᵢ s + ½ s B s, of which the largest counts.

    Attributes:
        values: shape (k,).
        slopes: shape (k, n).
        curvature: shape (n, n), positive definite.
    """

    values: Floats
    slopes: Floats
    curvature: Floats

    def at(self, step: Floats) -> float:
        """The largest of them after a step."""
        bent = float(step @ self.curvature @ step) / 2
        return float((self.values + self.slopes @ step).max()) + bent


def best_step(
    model: Model, rows: Rows, firm: Rows, box: tuple[Floats, Floats], penalty: float
) -> tuple[Floats, float]:
    """Minimise the model in a box under limits, by sequential least squares (SciPy's SLSQP).

    Args:
        model: objectives.
        rows: limits that share one excess t ≥ 0 with a price, so that there is always a step.
        firm: limits without an excess.
        box: lowest and highest step.
        penalty: price of t, in sizes of the objective.

    Returns:
        The step, shape (n,), and t.
    """
    low, high = box
    soft, rows = len(rows.values), rows.with_rows(firm)
    free = np.zeros(len(rows.values))
    free[:soft] = 1.0
    n, several = len(low), len(model.values) > 1
    size = n + 1 + several  # the step, t, and the largest objective
    size_of = max(float(np.abs(model.values).max()), 1e-12)

    def objective(y: Floats) -> tuple[float, Floats]:
        step = y[:n]
        bent = model.curvature @ step
        slope = np.zeros(size)
        slope[:n] = bent
        slope[n] = penalty * size_of
        value = float(step @ bent) / 2 + penalty * size_of * y[n]
        if several:
            slope[n + 1] = 1.0
            return value + y[n + 1], slope
        slope[:n] += model.slopes[0]
        return value + float(model.slopes[0] @ step), slope

    def limits(y: Floats) -> Floats:
        step = y[:n]
        found = free * y[n] - rows.values - rows.slopes @ step - rows.bend * float(step @ step) / 2
        if several:
            above = y[n + 1] - (model.values - model.values.max()) - model.slopes @ step
            found = np.concatenate([found, above / size_of])
        return np.asarray(found)

    def limit_slopes(y: Floats) -> Floats:
        step = y[:n]
        found = np.zeros((len(rows.values) + several * len(model.values), size))
        m = len(rows.values)
        found[:m, :n] = -rows.slopes - rows.bend[:, None] * step
        found[:m, n] = free
        if several:
            found[m:, :n] = -model.slopes / size_of
            found[m:, n + 1] = 1.0 / size_of
        return found

    begin = np.zeros(size)
    begin[n] = max(float(rows.values[:soft].max(initial=0.0)), 0.0)
    bounds = [*zip(low, high, strict=True), (0.0, None), *([(None, None)] * several)]
    constraints = (
        [{"type": "ineq", "fun": limits, "jac": limit_slopes}] if len(limits(begin)) else []
    )
    found = minimize(
        objective, begin, jac=True, method="SLSQP", bounds=bounds, constraints=constraints,
        options={"maxiter": 60, "ftol": 1e-9 * size_of},
    )  # fmt: skip
    step = np.clip(found.x[:n], low, high)
    return np.asarray(step), float(max(found.x[n], 0.0))

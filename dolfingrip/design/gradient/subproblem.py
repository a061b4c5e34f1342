"""The best step by a model of a problem, inside the box in which the model is trusted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import clarabel
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

Floats = NDArray[np.float64]

TOLERANCE: Final = 1e-10
"""Of the interior-point method: gaps and limits, by their sizes."""


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
class ObjectiveModel:
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
    model: ObjectiveModel, rows: Rows, firm: Rows, box: tuple[Floats, Floats], penalty: float
) -> tuple[Floats, float]:
    """Minimise the model in a box under limits, by an interior-point method (Clarabel).

    The unknowns are the step s, t, the largest objective's change, and q ≥ ½|s|², which is a cone.
    All limits then are linear, so the problem is no larger with the bend of a limit.

    Args:
        model: objectives.
        rows: limits that share one excess t ≥ 0 with a price, so that there is always a step.
        firm: limits without an excess.
        box: lowest and highest step.
        penalty: price of t, in sizes of the objective.

    Returns:
        The step, shape (n,), and t. Where limits contradict each other, the step is only in its
        box.
    """
    n, k, soft = len(box[0]), len(model.values), len(rows.values)
    rows = rows.with_rows(firm)
    m = len(rows.values)
    of_values = max(float(np.abs(model.values).max()), 1e-12)
    scale = max(of_values, float((np.abs(model.slopes) @ (box[1] - box[0])).max()))
    linear = np.zeros((m + k + 1 + 2 * n, n + 3))
    linear[:m, :n], linear[:m, n + 2] = rows.slopes, rows.bend
    linear[:soft, n] = -1.0
    linear[m : m + k, :n], linear[m : m + k, n + 1] = model.slopes / scale, -1.0
    linear[m + k, n] = -1.0
    linear[m + k + 1 :, :n] = np.vstack([np.eye(n), -np.eye(n)])
    objectives = (model.values - model.values.max()) / scale
    most = np.concatenate([-rows.values, -objectives, [0.0], box[1], -box[0]])
    # |(√2 s, q − 1)| ≤ q + 1 says |s|² ≤ 2 q
    cone = np.zeros((n + 2, n + 3))
    cone[0, n + 2] = cone[1, n + 2] = -1.0
    cone[2:, :n] = -np.sqrt(2.0) * np.eye(n)
    curvature = np.zeros((n + 3, n + 3))
    curvature[:n, :n] = np.triu(model.curvature) / scale
    price = np.concatenate([np.zeros(n), [penalty * of_values / scale, 1.0, 0.0]])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    found = clarabel.DefaultSolver(
        csc_matrix(curvature),
        price,
        csc_matrix(np.vstack([linear, cone])),
        np.concatenate([most, [1.0, -1.0], np.zeros(n)]),
        [clarabel.NonnegativeConeT(len(linear)), clarabel.SecondOrderConeT(n + 2)],
        settings,
    ).solve()
    values = np.asarray(found.x)
    return np.clip(values[:n], *box), max(float(values[n]), 0.0)

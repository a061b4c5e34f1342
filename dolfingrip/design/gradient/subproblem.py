"""The best step by a model of a problem, inside the box in which the model is trusted.

Limits of the unloaded shape are linearised anew until they hold exactly.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import clarabel
import numpy as np
from scipy.sparse import csc_matrix

from dolfingrip.design.gradient.file import CELL_QUALITY, OF_MANY, OVERHANG
from dolfingrip.design.gradient.problem import Constraint, Floats
from dolfingrip.design.gradient.shape import UnloadedShape
from dolfingrip.design.quantities.quantity import Quantity

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
            np.concatenate([block.values for block in every]),
            np.concatenate([block.slopes for block in every]),
            np.concatenate([block.bend for block in every]),
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
    solution = clarabel.DefaultSolver(
        csc_matrix(curvature),
        price,
        csc_matrix(np.vstack([linear, cone])),
        np.concatenate([most, [1.0, -1.0], np.zeros(n)]),
        [clarabel.NonnegativeConeT(len(linear)), clarabel.SecondOrderConeT(n + 2)],
        settings,
    ).solve()
    values = np.asarray(solution.x)
    return np.clip(values[:n], *box), max(float(values[n]), 0.0)


@dataclass(frozen=True, slots=True)
class DescentPolicy:
    """How steps are chosen and judged. Variables are scaled to their ranges, 0 to 1.

    Attributes:
        largest_radius, least_radius: of the box around a design in which the model is
            trusted.
        failed, rejected: factor of the radius after a solve that failed, and after a step that did
            not improve.
        good, poor: ratio of a gain to the expected one above which the radius grows twofold, and
            below which it halves.
        enough: expected gain, as a part of the objective, below which a descent ends.
        broken: part of a limit's size by which a simulated limit may be exceeded.
        kept: part of its size by which a limit of the unloaded shape may be.
        corrections: largest number of times that limits of the shape are linearised anew for one
            step.
        aimed, nearest: the same where no simulated limit is held, and further ones in which the
            nearest step within the limits is sought: the best one may jump from one to another.
        shorter: factor of the step that the nearest one is sought to; no step at all keeps them.
        least_cell_quality: which every cell of the mesh keeps: its scaled Jacobian, and half of it
            its edges, by those at the start.
        near_cell_quality: cells within this of it are among the limits of a step.
        near_mm: walls and gaps within this distance of their limit are among the limits of a step.
        most_rows: largest number of pairs of faces among them at first.
        bundle: number of earlier designs whose simulated limits, made linear there, count too.
        penalty: price of breaking a limit in a step's model, in sizes of the objective.
        ridge: of the mean curvature of a sum of squares, added in every direction: what its parts
            do not tell has some.
        digits: decimals of a scaled variable; its value has two fewer. So a run that goes on
            computes the same designs.
    """

    largest_radius: float = 1.0
    least_radius: float = 1e-3
    failed: float = 0.4
    rejected: float = 0.5
    good: float = 0.7
    poor: float = 0.25
    enough: float = 2e-4
    broken: float = 1e-4
    kept: float = 1e-6
    corrections: int = 8
    aimed: int = 8
    nearest: int = 11
    shorter: float = 0.9
    least_cell_quality: float = 0.15
    near_cell_quality: float = 0.5
    near_mm: float = 1.5
    most_rows: int = 400
    bundle: int = 8
    penalty: float = 20.0
    ridge: float = 1e-4
    digits: int = 12


def size_of(limit: float) -> float:
    """Return the size that a limit's excess is a part of."""
    return abs(limit) if abs(limit) > 1e-9 else 1.0


class ShapeLimits:
    """Limits of the shape, linearised where a step ends.

    Args:
        limits: of the problem, with their values.
        ranges: shape (variables,), of the variables.
        policy: how near a limit counts, and the quality that every cell of the mesh keeps.

    Attributes:
        rows: the linear limits.
    """

    def __init__(
        self, limits: Iterable[tuple[Constraint, float]], ranges: Floats, policy: DescentPolicy
    ) -> None:
        of_shape = [pair for pair in limits if pair[0].quantity.experiment is None]
        least = policy.least_cell_quality
        self._policy = policy
        self._limits = [*of_shape, (Constraint(Quantity(CELL_QUALITY), -1.0, least), least)]
        self._range, self._n = ranges, len(ranges)
        self._chosen: dict[int, set[int]] = {}
        self.rows = Rows.none(self._n)

    def at(self, shape: UnloadedShape, step: Floats) -> None:
        """Linearise them at a shape that a step leads to."""
        values, slopes = [], []
        for i, (limit, value) in enumerate(self._limits):
            name, size = limit.quantity.name, size_of(value)
            if name in OF_MANY:
                every = shape.rows(name)
                above: Floats = np.asarray(limit.sign * (every - value) / size, dtype=float)
                chosen = self._choose(i, above, size)
                slope = shape.row_gradients(name, chosen).T
                above = above[chosen]
            else:
                above = np.array([limit.sign * (shape.value(name) - value) / size])
                slope = shape.gradient(name)[None]
            scaled = limit.sign * slope * self._range / size
            # a little inside, so that it holds when what is left out of the linear part is small
            values.append(above - scaled @ step + self._policy.kept / 2)
            slopes.append(scaled)
        if values:
            c = np.concatenate(values)
            self.rows = Rows(c, np.concatenate(slopes), np.zeros(len(c)))

    def _choose(self, i: int, above: Floats, size: float) -> np.ndarray:
        """Rows that a step may break: the nearest ones, and those that one has broken."""
        chosen = self._chosen.setdefault(i, set())
        of_cells = self._limits[i][0].quantity.name == CELL_QUALITY
        within = self._policy.near_cell_quality if of_cells else self._policy.near_mm
        near = np.flatnonzero(above > -within / size)
        chosen.update(
            map(int, near[np.argsort(-above[near], kind="stable")][: self._policy.most_rows])
        )
        return np.array(sorted(chosen), dtype=np.int64)

    def _worsts(self, shape: UnloadedShape) -> list[float]:
        worsts = []
        for limit, value in self._limits:
            if limit.quantity.name == OVERHANG:
                above = shape.rows(OVERHANG) - value
                worsts.append(float(above.max(initial=-1.0)) / size_of(value))
                continue
            worsts.append(limit.sign * (shape.value(limit.quantity.name) - value) / size_of(value))
        return worsts

    @staticmethod
    def folds(shape: UnloadedShape) -> bool:
        """Tell whether a cell is turned inside out, where its slopes lead nowhere."""
        return shape.value(CELL_QUALITY) <= 0

    def worst(self, shape: UnloadedShape) -> float:
        """By how much the worst limit is broken, as a part of its size; below 0 if all are kept."""
        return max(self._worsts(shape), default=-1.0)

    def worst_limit(self, shape: UnloadedShape) -> tuple[Constraint, float]:
        """The limit that is broken most, and its quantity's value."""
        limit, _ = self._limits[int(np.argmax(self._worsts(shape)))]
        return limit, shape.value(limit.quantity.name)

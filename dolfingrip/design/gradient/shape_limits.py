"""Limits of the unloaded shape, linearised anew until they hold exactly."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dolfingrip.design.gradient.policy import DescentPolicy
from dolfingrip.design.gradient.problem import Constraint, Floats
from dolfingrip.design.gradient.quantity import CELL_QUALITY, OF_MANY, OVERHANG
from dolfingrip.design.gradient.shape import UnloadedShape
from dolfingrip.design.gradient.subproblem import Rows
from dolfingrip.design.quantities.quantity import Quantity


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
        asked = [each for each in limits if each[0].quantity.experiment is None]
        least = policy.least_cell_quality
        self._policy = policy
        self._limits = [*asked, (Constraint(Quantity(CELL_QUALITY), -1.0, least), least)]
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
        known = self._chosen.setdefault(i, set())
        of_cells = self._limits[i][0].quantity.name == CELL_QUALITY
        within = self._policy.near_cell_quality if of_cells else self._policy.near_mm
        near = np.flatnonzero(above > -within / size)
        known.update(
            map(int, near[np.argsort(-above[near], kind="stable")][: self._policy.most_rows])
        )
        return np.array(sorted(known), dtype=np.int64)

    def _worsts(self, shape: UnloadedShape) -> list[float]:
        found = []
        for limit, value in self._limits:
            if limit.quantity.name == OVERHANG:
                above = shape.rows(OVERHANG) - value
                found.append(float(above.max(initial=-1.0)) / size_of(value))
                continue
            found.append(limit.sign * (shape.value(limit.quantity.name) - value) / size_of(value))
        return found

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

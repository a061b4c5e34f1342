"""The best step by a model of a problem, inside the box in which the model is trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

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


@dataclass(frozen=True, slots=True)
class InteriorPolicy:
    """The numbers of the interior-point method.

    Attributes:
        iterations: largest number of Newton steps.
        gap: complementarity, as a part of the objective's size, at which it ends.
        back: part of the way to the nearest bound that a step goes.
        least: distance from a bound below which rounding says nothing.
    """

    iterations: int = 80
    gap: float = 1e-12
    back: float = 0.995
    least: float = 1e-15


INTERIOR = InteriorPolicy()


def best_step(
    model: Model, rows: Rows, firm: Rows, box: tuple[Floats, Floats], penalty: float
) -> tuple[Floats, float]:
    """Minimise the model in a box under limits, by a primal-dual interior-point method.

    Args:
        model: objectives.
        rows: limits that share one excess t ≥ 0 with a price, so that there is always a step.
        firm: limits without an excess.
        box: lowest and highest step.
        penalty: price of t, in sizes of the objective.

    Returns:
        The step, shape (n,), and t.
    """
    found = _Interior(model, rows, firm, box, penalty).solve()
    n = len(box[0])
    return np.asarray(np.clip(found[:n], *box)), float(max(found[n], 0.0))


@dataclass(slots=True)
class _Iterate:
    """Unknowns, slacks, and multipliers of limits, lower and upper bounds; or changes of them."""

    y: Floats
    slack: Floats
    dual: Floats
    pull: Floats
    push: Floats


class _Interior:
    """A convex programme of a few hundred unknowns.

    Each limit has a slack; predictor and corrector are Mehrotra's (SIAM J. Optim. 2, 1992). The
    bend of a limit is a multiple of |s|², so the Newton matrix is no larger than the step. Unknowns
    are the step, t, and the largest objective's change as a part of the scale.
    """

    def __init__(
        self, model: Model, rows: Rows, firm: Rows, box: tuple[Floats, Floats], penalty: float
    ) -> None:
        n, k, soft = len(box[0]), len(model.values), len(rows.values)
        rows = rows.with_rows(firm)
        m = len(rows.values)
        of_values = max(float(np.abs(model.values).max()), 1e-12)
        scale = max(of_values, float((np.abs(model.slopes) @ (box[1] - box[0])).max()))
        self._n, self._low, self._high = n, np.append(box[0], 0.0), np.append(box[1], np.inf)
        self._slope = np.zeros((m + k, n + 2))
        self._slope[:m, :n], self._slope[:soft, n] = rows.slopes, -1.0
        self._slope[m:, :n], self._slope[m:, n + 1] = model.slopes / scale, -1.0
        objectives = (model.values - model.values.max()) / scale
        self._value = np.concatenate([rows.values, objectives])
        self._bend = np.concatenate([rows.bend, np.zeros(k)])
        self._price = np.append(np.zeros(n), [penalty * of_values / scale, 1.0])
        self._curvature = model.curvature / scale
        fixed = self._high - self._low <= 0
        self._fixed = np.append(fixed, False)
        self._lower = np.flatnonzero(~fixed)
        self._upper = np.flatnonzero(~fixed & np.isfinite(self._high))
        self._excess = float(rows.values[:soft].max(initial=0.0))

    def solve(self) -> Floats:
        """The unknowns; where limits contradict each other, those of the last iteration."""
        n = self._n
        y = np.append((self._low[:n] + self._high[:n]) / 2, [1.0 + self._excess, 1.0])
        slack = np.maximum(-self._limits(y)[0], 1e-2)
        dual = np.ones(len(slack))
        at = _Iterate(y, slack, dual, np.ones(len(self._lower)), np.ones(len(self._upper)))
        for _ in range(INTERIOR.iterations):
            up, down = self._room(at.y)
            pairs = (at.slack, at.dual), (up, at.pull), (down, at.push)
            total = sum(len(one) for one, _ in pairs)
            mean = float(sum(one @ other for one, other in pairs)) / total
            found, slopes = self._limits(at.y)
            if mean < INTERIOR.gap * max(1.0, float(np.abs(self._value).max())):
                break
            try:
                factor = cho_factor(self._matrix(at, slopes), check_finite=False)
            except np.linalg.LinAlgError:
                break
            none = np.zeros_like(at.slack), np.zeros_like(up), np.zeros_like(down)
            change = self._change(at, factor, found, slopes, 0.0, none)
            primal, duals = self._reaches(at, change)
            sides = change.y[self._lower], -change.y[self._upper]
            ahead = float(
                (at.slack + primal * change.slack) @ (at.dual + duals * change.dual)
                + (up + primal * sides[0]) @ (at.pull + duals * change.pull)
                + (down + primal * sides[1]) @ (at.push + duals * change.push)
            )
            bent = change.slack * change.dual, sides[0] * change.pull, sides[1] * change.push
            centre = mean * (ahead / total / mean) ** 3
            change = self._change(at, factor, found, slopes, centre, bent)
            part = min(1.0, INTERIOR.back * min(self._reaches(at, change)))
            at = _Iterate(
                at.y + part * change.y,
                at.slack + part * change.slack,
                at.dual + part * change.dual,
                at.pull + part * change.pull,
                at.push + part * change.push,
            )
        return at.y

    def _limits(self, y: Floats) -> tuple[Floats, Floats]:
        """Values and slopes of limits and objectives."""
        step, slopes = y[: self._n], self._slope.copy()
        slopes[:, : self._n] += self._bend[:, None] * step
        return self._value + self._slope @ y + self._bend * float(step @ step) / 2, slopes

    def _room(self, y: Floats) -> tuple[Floats, Floats]:
        """Distances from the bounds, which rounding leaves above 0."""
        lower, upper = self._lower, self._upper
        up, down = y[lower] - self._low[lower], self._high[upper] - y[upper]
        return np.maximum(up, INTERIOR.least), np.maximum(down, INTERIOR.least)

    def _matrix(self, at: _Iterate, slopes: Floats) -> Floats:
        up, down = self._room(at.y)
        n, fixed = self._n, self._fixed
        found = slopes.T @ ((at.dual / at.slack)[:, None] * slopes)
        found[:n, :n] += self._curvature
        diagonal = np.zeros(len(found))
        diagonal[:n] += float(at.dual @ self._bend)
        diagonal[self._lower] += at.pull / up
        diagonal[self._upper] += at.push / down
        found[np.diag_indices_from(found)] += diagonal
        found[fixed], found[:, fixed] = 0.0, 0.0
        found[fixed, fixed] = 1.0
        return np.asarray(found)

    def _change(
        self,
        at: _Iterate,
        factor: tuple[Floats, bool],
        values: Floats,
        slopes: Floats,
        centre: float,
        bent: tuple[Floats, Floats, Floats],
    ) -> _Iterate:
        """Newton's change towards products of slacks and multipliers that are ``centre``."""
        up, down = self._room(at.y)
        excess = values + at.slack
        balance = self._price + slopes.T @ at.dual
        balance[: self._n] += self._curvature @ at.y[: self._n]
        balance[self._lower] -= at.pull
        balance[self._upper] += at.push
        off = centre - at.slack * at.dual - bent[0]
        below = centre - up * at.pull - bent[1]
        above = centre - down * at.push - bent[2]
        right = -balance - slopes.T @ ((off + at.dual * excess) / at.slack)
        right[self._lower] += below / up
        right[self._upper] -= above / down
        right[self._fixed] = 0.0
        y = cho_solve(factor, right, check_finite=False)
        slack = -excess - slopes @ y
        return _Iterate(
            y,
            slack,
            (off - at.dual * slack) / at.slack,
            (below - at.pull * y[self._lower]) / up,
            (above + at.push * y[self._upper]) / down,
        )

    def _reaches(self, at: _Iterate, change: _Iterate) -> tuple[float, float]:
        """The largest parts of a change that leave distances, and multipliers, above 0."""
        up, down = self._room(at.y)
        distances = (
            (at.slack, change.slack),
            (up, change.y[self._lower]),
            (down, -change.y[self._upper]),
        )
        multipliers = (at.dual, change.dual), (at.pull, change.pull), (at.push, change.push)
        return _reach(*distances), _reach(*multipliers)


def _reach(*pairs: tuple[Floats, Floats]) -> float:
    """The largest part of some changes, up to 1, that leaves values above 0."""
    found = 1.0
    for value, change in pairs:
        falling = change < 0
        if falling.any():
            found = min(found, float((-value[falling] / change[falling]).min()))
    return found

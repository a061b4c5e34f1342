"""A front: the best objective for each limit of another quantity, by few simulations.

Gaussian processes learn from values and gradients what is simulated of the two quantities. A number
of the unloaded shape is exact. The next simulation is where the front is unsure most. At the end
functions are drawn from the processes; where each of them has its best design tells how well the
place of a design is known.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from dolfingrip.config import ConfigError
from dolfingrip.design.gradient.evaluation import DesignNumbers, DesignSimulations
from dolfingrip.design.gradient.file import FrontTable
from dolfingrip.design.gradient.problem import Floats, Problem, Scaling
from dolfingrip.design.gradient.shape import UnloadedShape, UnloadedShapes
from dolfingrip.design.quantities.quantity import Quantity, objective
from dolfingrip.design.surrogate.process import GradientProcess
from dolfingrip.experiments.simulate import Compute
from dolfingrip.files.front import FrontFile, FrontLevel, SimulatedDesign
from dolfingrip.files.objective import Sense

CANDIDATES, LEVELS, SEED, FIRST = 2048, 40, 1, 4

DRAWS, SHARE = 400, 0.9
"""Number of functions that are drawn, and the share of them that an interval holds."""

SAME = 1e-12
"""Difference below which a candidate is at a limit."""


class _Front(NamedTuple):
    """The front by what is known so far; less is better in both quantities.

    Attributes:
        limits: shape (levels,), of the limited quantity, rising.
        best: shape (levels,), row of the best candidate for each limit.
        mean, deviation: shape (levels,), of the improved quantity there.
    """

    limits: Floats
    best: np.ndarray
    mean: Floats
    deviation: Floats


class _Signed:
    """One of the two quantities, times its sign: less is better.

    Args:
        quantity: of a design.
        sign: 1 where less is better, −1 where more is.
        size: shape (variables,), the ranges that derivatives are scaled by.
        seed: of what is drawn.

    Attributes:
        exact: shape (candidates,), signed, where it is a number of the shape; else None.
        values: of the designs that were simulated, as they are.
    """

    def __init__(self, quantity: Quantity, sign: float, size: Floats, seed: int) -> None:
        self.quantity, self.sign = quantity, sign
        self.exact: Floats | None = None
        self.values: list[float] = []
        self._slopes: list[Floats] = []
        self._size, self._seed = size, seed
        self._process: GradientProcess | None = None

    def learn(self, shape: UnloadedShape, numbers: DesignNumbers) -> None:
        """Add a design: its shape, or the condition in which it is worst."""
        if self.exact is not None:
            self.values.append(shape.value(self.quantity.name))
            return
        by_condition = [by[self.quantity] for by in numbers.by_condition]
        worst = max(by_condition, key=lambda one: self.sign * one.value)
        self.values.append(worst.value)
        self._slopes.append(worst.slopes * self._size)

    def predict(self, candidates: Floats, seen: Sequence[int]) -> tuple[Floats, Floats]:
        """Mean and deviation at all candidates, from those that were simulated."""
        if self.exact is not None:
            return self.exact, np.zeros(len(self.exact))
        slopes = np.array(self._slopes)
        self._process = GradientProcess(candidates[seen], np.array(self.values), slopes, self._seed)
        mean, deviation = self._process.predict(candidates)
        return self.sign * mean, deviation

    def draws(self, candidates: Floats, chosen: np.ndarray) -> Floats:
        """Functions drawn at some candidates, shape (draws, chosen)."""
        if self.exact is not None:
            return np.broadcast_to(self.exact[chosen], (DRAWS, int(chosen.sum())))
        assert self._process is not None
        return self.sign * self._process.draws(candidates[chosen], DRAWS)


class FrontFinder:
    """Finds a front.

    Args:
        problem: without limits of simulated quantities.
        table: range of the limits, and how sure the front shall be.
        compute: what computes jobs.
        say: called with the number of simulations, the uncertainty and whether the last one failed.
    """

    def __init__(
        self,
        problem: Problem,
        table: FrontTable,
        compute: Compute,
        say: Callable[[int, float, bool], None] = lambda done, unsure, failed: None,
    ) -> None:
        assert problem.against is not None
        self._problem, self._asked, self._say = problem, table, say
        self._simulations = DesignSimulations(problem, compute)
        self._shapes, self._scaling = UnloadedShapes(problem), Scaling(problem.variables)
        size, sign = self._scaling.size, 1.0 if table.sense == "at most" else -1.0
        self._limited = _Signed(problem.against, sign, size, SEED + 1)
        self._improved = _Signed(problem.objective, problem.sign, size, SEED)
        self._failures: list[str] = []

    def run(self) -> FrontFile:
        """Simulate until the front is sure enough, or the simulations are spent.

        Returns:
            The front, and the designs that were simulated.

        Raises:
            ConfigError: one line, where no design has such limits, or all simulations fail.
        """
        begun = time.monotonic()
        candidates = self._candidates()
        taken = self._first(candidates)
        seen: list[int] = []
        areas: list[float] = []
        unsure: list[float] = []
        failures, spent = self._failures, 0
        front: _Front | None = None
        while spent < self._problem.method.simulations:
            if len(seen) + len(failures) < len(taken):
                chosen = taken[len(seen) + len(failures)]
            elif front is None:
                break
            else:
                chosen = int(front.best[int(np.argmax(front.deviation))])
            values = self._scaling.values(candidates[chosen])
            numbers = self._simulations.at(values)
            spent += numbers.simulations
            if numbers.failure:
                failures.append(numbers.failure)
                free = np.arange(len(candidates)) != chosen
                candidates = candidates[free]
                for signed in (self._limited, self._improved):
                    signed.exact = None if signed.exact is None else signed.exact[free]
                seen = [i - (i > chosen) for i in seen]
                taken = [i - (i > chosen) for i in taken]
            else:
                seen.append(chosen)
                for signed in (self._limited, self._improved):
                    signed.learn(self._shapes.at(values), numbers)
            if len(seen) >= 2:
                front = self._front(candidates, seen)
                areas.append(float(np.trapezoid(front.mean.max() - front.mean, front.limits)))
                unsure.append(float(front.deviation.max()) / (float(np.ptp(front.mean)) or 1.0))
            self._say(spent, unsure[-1] if unsure else 1.0, bool(numbers.failure))
            tried = len(seen) + len(failures)
            if tried >= len(taken) and front and unsure[-1] < self._asked.unsure:
                break
        if front is None:
            why = failures[-1] if failures else "too few simulations are allowed"
            raise ConfigError(f"front: no two designs could be simulated: {why}")
        limited, improved = self._limited, self._improved
        intervals = self._places(candidates, seen, front)
        keys = [v.key for v in self._problem.variables]
        sense: Sense = "minimise" if self._problem.sign > 0 else "maximise"
        return FrontFile(
            objectives=(
                objective(str(limited.quantity), self._asked.sense),
                objective(str(improved.quantity), sense),
            ),
            ranges={v.key: (v.low, v.high) for v in self._problem.variables},
            levels=tuple(
                FrontLevel(
                    limit=limited.sign * float(front.limits[i]),
                    mean=improved.sign * float(front.mean[i]),
                    deviation=float(front.deviation[i]),
                    inputs=dict(zip(keys, map(tuple, intervals[i].tolist()), strict=True)),
                )
                for i in range(len(front.limits))
            ),
            simulated=tuple(
                SimulatedDesign(
                    inputs=dict(zip(keys, map(float, self._scaling.values(design)), strict=True)),
                    values=values,
                )
                for design, *values in zip(
                    candidates[seen], limited.values, improved.values, strict=True
                )
            ),
            simulations=len(seen) + len(failures),
            failed=len(failures),
            hypervolumes=tuple(areas),
            unsure=tuple(unsure),
            wall_s=round(time.monotonic() - begun, 1),
        )

    def _candidates(self) -> Floats:
        """Scaled designs that keep the limits of the shape, and their exact numbers.

        They are a grid of two variables, a Sobol sequence of more.
        """
        count = len(self._scaling.size)
        if count <= 2:
            axis = np.linspace(0, 1, round(CANDIDATES ** (1 / count)))
            every = np.stack(np.meshgrid(*[axis] * count, indexing="ij"), axis=-1)
            every = every.reshape(-1, count)
        else:
            every = np.asarray(qmc.Sobol(count, rng=SEED).random(CANDIDATES))
        of_shape = [q for q in (self._limited, self._improved) if q.quantity.experiment is None]
        numbers = np.array([self._numbers(scaled, of_shape) for scaled in every])
        kept = ~np.isnan(numbers[:, 0])
        if self._limited in of_shape:
            at = self._limited.sign * numbers[:, 1]
            kept &= (at >= self._asked.low) & (at <= self._asked.high)
            if not kept.any():
                self._refuse(at)
        for signed, column in zip(of_shape, numbers[kept].T[1:], strict=True):
            signed.exact = column
        return np.asarray(every[kept])

    def _numbers(self, scaled: Floats, of_shape: Sequence[_Signed]) -> list[float]:
        """Numbers of a design's shape, behind a first one; NaN where a limit is broken."""
        try:
            shape = self._shapes.at(self._scaling.values(scaled))
            for limit in self._problem.limits:
                value = shape.value(limit.quantity.name)
                if limit.limit is not None and limit.sign * (value - limit.limit) > 0:
                    raise ConfigError(str(limit))
            return [0.0, *(signed.sign * shape.value(signed.quantity.name) for signed in of_shape)]
        except ConfigError:
            return [np.nan] * (1 + len(of_shape))

    def _refuse(self, reached: Floats) -> None:
        reach = "nothing"
        if not np.isnan(reached).all():
            reach = f"{np.nanmin(reached):.4g} to {np.nanmax(reached):.4g}"
        reach += " in the parameters' ranges"
        if self._failures:
            reach += f", not known of {len(self._failures)} designs ({self._failures[-1]})"
        raise ConfigError(
            f"front.low, high: {self._limited.quantity} is {reach}; "
            "allowed: low and high among these"
        )

    def _first(self, candidates: Floats) -> list[int]:
        """Rows of the first designs: apart from one another, and along an exact number."""
        exact, taken = self._limited.exact, list[int]()
        along = np.zeros(len(candidates)) if exact is None else exact
        nearest = len(along) if exact is None else max(len(along) // 20, 1)
        for place in np.linspace(along.min(), along.max(), FIRST):
            near = np.argsort(np.abs(along - place), kind="stable")[:nearest]
            apart = [
                min((float(np.abs(candidates[i] - candidates[j]).max()) for j in taken), default=1)
                for i in near
            ]
            taken.append(int(near[int(np.argmax(apart))]))
        return taken

    def _front(self, candidates: Floats, seen: Sequence[int]) -> _Front:
        """The front by what is known; deviations of a learnt limit count by the front's slope."""
        against, sure = self._limited.predict(candidates, seen)
        mean, deviation = self._improved.predict(candidates, seen)
        low, high = float(against.min()), float(against.max())
        if self._limited.exact is None:
            ends = sorted(self._limited.sign * end for end in (self._asked.low, self._asked.high))
            if len(seen) >= FIRST and not max(low, ends[0]) < min(high, ends[1]):
                self._refuse(self._limited.sign * against)
            low, high = max(low, ends[0]), min(high, ends[1])
        limits: Floats = np.linspace(low, max(low, high), LEVELS, dtype=float)
        within = against[None] <= limits[:, None] + SAME
        best = np.where(within, mean[None], np.inf).argmin(axis=1)
        best_mean = mean[best]
        slope = np.gradient(best_mean, limits) if limits[0] < limits[-1] else np.zeros(LEVELS)
        return _Front(limits, best, best_mean, np.hypot(deviation[best], slope * sure[best]))

    def _places(self, candidates: Floats, seen: Sequence[int], front: _Front) -> Floats:
        """Best value of each variable for each limit, and its interval by drawn functions.

        Returns:
            Shape (levels, variables, 3).
        """
        against, sure = self._limited.predict(candidates, seen)
        mean, deviation = self._improved.predict(candidates, seen)
        # the least limit that a candidate may keep
        level = np.searchsorted(front.limits, against - 4 * sure - SAME)
        worst = front.mean + 4 * front.deviation
        near = mean - 4 * deviation <= worst[np.minimum(level, len(front.limits) - 1)]
        near[front.best] = True
        drawn, limited = (goal.draws(candidates, near) for goal in (self._improved, self._limited))
        ends = []
        for limit in front.limits:
            best = np.where(limited <= limit + SAME, drawn, np.inf).argmin(axis=1)
            tails = [(1 - SHARE) / 2, (1 + SHARE) / 2]
            ends.append(np.quantile(candidates[near][best], tails, axis=0))
        low, high = np.transpose(ends, (1, 0, 2))
        values = [self._scaling.values(scaled) for scaled in (candidates[front.best], low, high)]
        return np.stack(values, axis=2)

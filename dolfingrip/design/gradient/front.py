"""A front: the best objective for each limit of a number of the shape, by few simulations.

A Gaussian process learns from values and gradients of the objective. The number of the shape is
exact, so the process alone is unsure; the next simulation is where its front is unsure most. At the
end functions are drawn from the process; where each of them has its best design tells how well the
place of a design is known.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.stats import qmc

from dolfingrip.config import ConfigError
from dolfingrip.design.gradient.evaluation import Compute, DesignSimulations, Floats
from dolfingrip.design.gradient.file import FrontTable
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.shape import UnloadedShapes
from dolfingrip.design.quantities.quantity import objective
from dolfingrip.design.surrogate.process import GradientProcess
from dolfingrip.files.front import FrontFile, FrontLevel, SimulatedDesign
from dolfingrip.files.objective import Sense

CANDIDATES, LEVELS, SEED, FIRST = 2048, 40, 1, 4

DRAWS, SHARE = 400, 0.9
"""Number of functions that are drawn, and the share of them that an interval holds."""


class FrontFinder:
    """Finds a front.

    Args:
        problem: without limits of simulated quantities.
        asked: number of the shape, its range and how sure the front shall be.
        compute: what computes jobs.
        say: called with the number of simulations, the uncertainty and whether the last one failed.
    """

    def __init__(
        self,
        problem: Problem,
        asked: FrontTable,
        compute: Compute,
        say: Callable[[int, float, bool], None] = lambda done, unsure, failed: None,
    ) -> None:
        self._problem, self._asked, self._say = problem, asked, say
        self._simulations, self._shapes = (
            DesignSimulations(problem, compute),
            UnloadedShapes(problem),
        )
        self._low = np.array([each.low for each in problem.variables])
        self._range = np.array([each.high for each in problem.variables]) - self._low

    def run(self) -> FrontFile:
        """Simulate until the front is sure enough, or the simulations are spent.

        Returns:
            The front with its uncertainty.

        Raises:
            ConfigError: one line, where no limit can be kept, or no two designs be simulated.
        """
        begun = time.monotonic()
        candidates = self._candidates()
        against = np.array([self._against(each) for each in candidates])
        kept = (against >= self._asked.low) & (against <= self._asked.high)
        if not kept.any():
            reach = f"{np.nanmin(against):.4g} to {np.nanmax(against):.4g}"
            raise ConfigError(
                f"front.low, high: {self._asked.against} is {reach} in the parameters' ranges; "
                "allowed: low and high among these"
            )
        candidates, against = candidates[kept], against[kept]
        taken: list[int] = []
        places = np.linspace(against.min(), against.max(), FIRST)
        for place in places:  # spread along the number of the shape, and apart from one another
            near = np.argsort(np.abs(against - place), kind="stable")[: max(len(against) // 20, 1)]
            apart = [
                min(
                    (float(np.abs(candidates[i] - candidates[j]).max()) for j in taken), default=1.0
                )
                for i in near
            ]
            taken.append(int(near[int(np.argmax(apart))]))
        limits = np.linspace(against.min(), against.max(), LEVELS)
        seen: list[int] = []
        values: list[float] = []
        slopes: list[Floats] = []
        areas: list[float] = []
        unsure: list[float] = []
        failed, spent = 0, 0
        front: tuple[np.ndarray, Floats, Floats] | None = None
        process: GradientProcess | None = None
        while spent < self._problem.method.simulations:
            if len(seen) + failed < len(taken):
                chosen = taken[len(seen) + failed]
            else:
                assert front is not None
                best, _, deviation = front
                chosen = int(best[int(np.argmax(deviation))])
            found = self._simulations.at(self._values(candidates[chosen]))
            spent += found.simulations
            if found.failure:
                failed += 1
                free = np.arange(len(candidates)) != chosen
                candidates, against = candidates[free], against[free]
                seen = [i - (i > chosen) for i in seen]
                taken = [i - (i > chosen) for i in taken]
            else:
                worst = [by[self._problem.objective] for by in found.by_condition]
                one = max(worst, key=lambda each: self._problem.sign * each.value)
                seen.append(chosen)
                values.append(one.value)
                slopes.append(one.slopes * self._range)
            if len(seen) >= 2:
                process = GradientProcess(candidates[seen], np.array(values), np.array(slopes))
                front = self._front(process, candidates, against, limits)
                areas.append(self._area(limits, front[1]))
                size = float(np.ptp(front[1])) or 1.0
                unsure.append(float(front[2].max()) / size)
            self._say(spent, unsure[-1] if unsure else 1.0, bool(found.failure))
            if len(seen) + failed >= len(taken) and unsure[-1] < self._asked.unsure:
                break
        if front is None or process is None:
            raise ConfigError("front: no two designs could be simulated")
        best, mean, deviation = front
        lowest, highest = self._places(process, candidates, against, limits, front)
        keys = [each.key for each in self._problem.variables]
        intervals = np.stack([self._values(candidates[best]), lowest, highest], axis=2)
        sense: Sense = "minimise" if self._problem.sign > 0 else "maximise"
        return FrontFile(
            objectives=(
                objective(self._asked.against, "at most"),
                objective(str(self._problem.objective), sense),
            ),
            ranges={each.key: (each.low, each.high) for each in self._problem.variables},
            levels=tuple(
                FrontLevel(
                    limit=float(limits[i]),
                    mean=float(mean[i]),
                    deviation=float(deviation[i]),
                    inputs=dict(zip(keys, map(tuple, intervals[i].tolist()), strict=True)),
                )
                for i in range(len(limits))
            ),
            simulated=tuple(
                SimulatedDesign(
                    inputs=dict(zip(keys, map(float, self._values(candidates[i])), strict=True)),
                    values=(float(against[i]), value),
                )
                for i, value in zip(seen, values, strict=True)
            ),
            simulations=len(values) + failed,
            failed=failed,
            hypervolumes=tuple(areas),
            unsure=tuple(unsure),
            wall_s=round(time.monotonic() - begun, 1),
        )

    def _candidates(self) -> Floats:
        """Scaled designs: a grid of two variables, a Sobol sequence of more."""
        count = len(self._range)
        if count <= 2:
            axis = np.linspace(0, 1, round(CANDIDATES ** (1 / count)))
            return np.stack(np.meshgrid(*[axis] * count, indexing="ij"), axis=-1).reshape(-1, count)
        return np.asarray(qmc.Sobol(count, rng=SEED).random(CANDIDATES))

    def _values(self, scaled: Floats) -> Floats:
        return np.asarray(np.round(self._low + scaled * self._range, 10) + 0.0)

    def _against(self, scaled: Floats) -> float:
        try:
            shape = self._shapes.at(self._values(scaled))
            for limit in self._problem.limits:
                value = shape.value(limit.quantity.name)
                if limit.limit is not None and limit.sign * (value - limit.limit) > 0:
                    return float("nan")
            return shape.value(self._asked.against)
        except ConfigError:
            return float("nan")

    def _front(
        self, process: GradientProcess, candidates: Floats, against: Floats, limits: Floats
    ) -> tuple[np.ndarray, Floats, Floats]:
        """Row of the best candidate for each limit, with mean and deviation there."""
        mean, deviation = process.predict(candidates)
        good = np.where(
            against[None] <= limits[:, None] + 1e-12, self._problem.sign * mean[None], np.inf
        )
        best = good.argmin(axis=1)
        return best, mean[best], deviation[best]

    def _places(
        self,
        process: GradientProcess,
        candidates: Floats,
        against: Floats,
        limits: Floats,
        front: tuple[np.ndarray, Floats, Floats],
    ) -> tuple[Floats, Floats]:
        """Interval of each variable of the best design for each limit, by drawn functions."""
        sign = self._problem.sign
        mean, deviation = process.predict(candidates)
        level = np.searchsorted(limits, against - 1e-12)  # the least limit that a candidate keeps
        best = sign * front[1] + 4 * front[2]
        near = sign * mean - 4 * deviation <= best[np.minimum(level, len(limits) - 1)]
        near[front[0]] = True
        chosen, own = candidates[near], against[near]
        drawn = sign * process.draws(chosen, DRAWS)
        ends = []
        for limit in limits:
            kept = np.flatnonzero(own <= limit + 1e-12)
            found = chosen[kept[drawn[:, kept].argmin(axis=1)]]
            ends.append(np.quantile(found, [(1 - SHARE) / 2, (1 + SHARE) / 2], axis=0))
        low, high = np.transpose(ends, (1, 0, 2))
        return self._values(low), self._values(high)

    def _area(self, limits: Floats, mean: Floats) -> float:
        """Area between the front and the worst objective on it, over the limits."""
        gain = np.abs(mean - (mean.max() if self._problem.sign > 0 else mean.min()))
        return float(np.trapezoid(gain, limits))

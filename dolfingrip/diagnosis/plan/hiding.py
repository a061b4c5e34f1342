"""A cause hidden in readings to be, which are then judged as measured ones are."""

from __future__ import annotations

import zlib
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import ndtri

from dolfingrip.diagnosis.answer.analysed import Analysed
from dolfingrip.diagnosis.core.case import Case
from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.evidence import Level
from dolfingrip.diagnosis.core.numbers import Cause, UnknownNumber
from dolfingrip.diagnosis.core.search import NONE, Key, levels, one_at_a_time
from dolfingrip.diagnosis.finger.unknowns import neutral
from dolfingrip.diagnosis.policy import ADDITIONS


@dataclass(frozen=True)
class Judged:
    """What a diagnosis would say of readings with a hidden cause.

    Attributes:
        alone: whether it would answer with this cause alone.
        within: whether with a set that has it.
        mass: probability of each effect that it finds.
    """

    alone: bool
    within: bool
    mass: dict[str, float]


@dataclass(frozen=True, eq=False)
class Judge:
    """Draws readings to be, and judges them."""

    planned: Analysed[Any]
    _before: dict[str, dict[Key, np.ndarray]] = field(default_factory=lambda: defaultdict(dict))

    @property
    def case(self) -> Case:
        """Without a cause."""
        return self.planned.case

    @cached_property
    def _levels(self) -> dict[float, Level]:
        return {level: Level(self.case, level) for level in levels()}

    @cached_property
    def _free(self) -> np.ndarray:
        """What the model's own numbers change, by the noise, shape (n, m)."""
        none, step = np.zeros(self.case.own), 1e-3
        plain = self.case.predicted(NONE, none)
        columns = [self.case.predicted(NONE, step * way) - plain for way in np.eye(self.case.own)]
        return self._levels[0.0].whitened(np.column_stack(columns) / step)

    def change(self, name: str, zeta: np.ndarray) -> np.ndarray:
        """Of the readings by a cause at ζ, shape (n,)."""
        none = np.zeros(self.case.own)
        with_it = self.case.predicted((name,), np.r_[none, zeta])
        return np.asarray(with_it - self.case.predicted(NONE, none))

    def strength(self, name: str, zeta: np.ndarray) -> float:
        """Length of a cause's change, the model's own numbers left free, standard deviations."""
        white = self._levels[0.0].whitened(self.change(name, zeta))
        free = self._free
        # as much as their priors let these follow
        pull = np.linalg.solve(free.T @ free + np.eye(free.shape[1]), free.T @ white)
        return float(np.sqrt(max(white @ (white - free @ pull), 0.0)))

    def judged(self, name: str, zeta: np.ndarray, rng: np.random.Generator) -> Judged:
        """A cause at ζ under noise, nuisances and a discrepancy as probable as it may be.

        More readings with the same ``rng`` have the same noise, as far as both go.
        """
        if self.strength(name, zeta) < ADDITIONS.faint:
            return Judged(alone=False, within=False, mass={})
        prior = levels()
        level = self._levels[float(rng.choice([*prior], p=[*prior.values()]))]
        own = level.coloured(rng.standard_normal(len(self.case.value)))
        value = self.case.base + self.change(name, zeta) + own
        posterior = one_at_a_time(
            {k: each.read(value) for k, each in self._levels.items()}, self._before[name]
        )
        decision = decide(posterior, single=True)
        within = decision.answer == "cause" and name in decision.first
        mass: dict[str, float] = defaultdict(float)
        for p, fit in zip(posterior.probability, posterior.fits, strict=True):
            for each in self.case.effects(fit.subset):
                mass[each] += float(p)
        return Judged(within and decision.first == (name,), within, dict(mass))


@dataclass(frozen=True, eq=False)
class Hidden:
    """A cause at strengths from its prior.

    Attributes:
        judge: of the readings.
        cause: the effect.
    """

    judge: Judge
    cause: Cause
    _drawn: dict[int, list[Judged]] = field(default_factory=dict)

    @cached_property
    def strengths(self) -> np.ndarray:
        """That are hidden, by the ordinary one, rising, shape (strengths,)."""
        first = next(each for each in self.cause.numbers if each.amplitude)
        middles = ndtri((np.arange(ADDITIONS.strengths) + 0.5) / ADDITIONS.strengths)
        values = np.array([first.prior.at(z) for z in middles])
        start, step = _start_and_step(self.cause, first)
        return np.asarray(np.sort(np.abs(values - start) / abs(step)))

    @property
    def label(self) -> str:
        """Its numbers at the ordinary strength, for people."""
        at = zip(self.cause.numbers, self.at(1.0), strict=True)
        return ", ".join(f"{n.key.rpartition('.')[2]} = {float(n.at(z)):.4g}" for n, z in at)

    def at(self, strength: float, rng: np.random.Generator | None = None) -> np.ndarray:
        """ζ of its numbers at a strength; those of its shape from their priors, or their middles.

        Args:
            strength: by the ordinary one.
            rng: draws the shape; None for the middles.
        """
        found = []
        for number, (low, high) in zip(
            self.cause.numbers, self.judge.case.boxes[self.cause.name], strict=True
        ):
            if number.amplitude:
                start, step = _start_and_step(self.cause, number)
                value = start + strength * step
                positive = number.prior.positive and value <= 0
                zeta = low if positive else number.prior.zeta(value)
            else:
                zeta = 0.0 if rng is None else float(rng.standard_normal())
            found.append(np.clip(zeta, low, high))
        return np.array(found)

    def drawn(self, place: int) -> list[Judged]:
        """The draws at one of the strengths."""
        if place not in self._drawn:
            name, strength = self.cause.name, float(self.strengths[place])
            found = []
            for turn in range(ADDITIONS.noises):
                rng = np.random.default_rng([zlib.crc32(name.encode()), place, turn])
                found.append(self.judge.judged(name, self.at(strength, rng), rng))
            self._drawn[place] = found
        return self._drawn[place]

    def counted(
        self, told: Callable[[Judged], bool], full: int = ADDITIONS.strengths
    ) -> np.ndarray:
        """How many draws are judged so at each strength, shape (strengths,).

        Not all are drawn: where none is, none is at a lower strength; where all are, all are at a
        higher one.

        Args:
            told: of a draw.
            full: place from which on all are known to be.
        """
        count = np.full(ADDITIONS.strengths, ADDITIONS.noises)

        def look(low: int, high: int, place: int) -> None:
            if low >= high:
                return
            count[place] = sum(told(each) for each in self.drawn(place))
            if count[place]:
                look(low, place, (low + place) // 2)
            else:
                count[low:place] = 0
            if count[place] < ADDITIONS.noises:
                look(place + 1, high, (place + 1 + high) // 2)
            else:
                count[place + 1 : high] = ADDITIONS.noises

        look(0, full, full - 1)
        return count


def _start_and_step(cause: Cause, number: UnknownNumber) -> tuple[float, float]:
    """The value at which an amplitude does nothing, and from there to the ordinary one."""
    start = neutral(cause, number)
    step = number.prior.mean - start
    if abs(step) <= 1e-9 * number.prior.spread:
        step = number.prior.spread if number.bounds[1] > start else -number.prior.spread
    return start, step

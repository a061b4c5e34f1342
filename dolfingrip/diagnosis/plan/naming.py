"""Which effects a diagnosis would name, at which strength, and with which it confuses them.

Each effect is hidden in turn, at strengths from its prior. The readings that it makes, with noise,
the rig's own errors and a discrepancy as probable as a diagnosis takes it to be, are searched and
decided as measured ones are, one cause at a time. The share of draws in which the answer is this
effect alone is the probability that it is named.
"""

from __future__ import annotations

import zlib
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import ndtri

from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.evidence import CovarianceModel
from dolfingrip.diagnosis.core.problem import InferenceProblem
from dolfingrip.diagnosis.core.search import Key, levels, one_at_a_time
from dolfingrip.diagnosis.core.strength import Visibility, at_strength, start_and_step
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY
from dolfingrip.files.plan import EffectOutlook


@dataclass(frozen=True)
class RecoveryOutcome:
    """The answer of a diagnosis to readings with a hidden cause.

    Attributes:
        alone: whether it would answer with this cause alone.
        within: whether with a set that has it.
        mass: probability of each effect that it finds.
    """

    alone: bool
    within: bool
    mass: dict[str, float]


@dataclass(frozen=True, eq=False)
class RecoveryTrial:
    """A recovery trial: draws readings with a hidden cause, and diagnoses them."""

    planned: Analysis[Any]
    _before: dict[str, dict[Key, np.ndarray]] = field(default_factory=lambda: defaultdict(dict))

    @property
    def problem(self) -> InferenceProblem:
        """Without a cause."""
        return self.planned.problem

    @cached_property
    def _levels(self) -> dict[float, CovarianceModel]:
        return {k: CovarianceModel(self.problem, k) for k in levels(self.problem.policy)}

    @cached_property
    def visibility(self) -> Visibility:
        """Strengths of causes."""
        return Visibility(self.problem, np.zeros(self.problem.nuisance_count))

    def diagnosed(self, name: str, zeta: np.ndarray, rng: np.random.Generator) -> RecoveryOutcome:
        """A cause at ζ under noise, nuisances and a discrepancy as probable as it may be.

        More readings with the same ``rng`` have the same noise, as far as both go.
        """
        if self.visibility.strength(name, zeta) < ADDITIONS.faint:
            return RecoveryOutcome(alone=False, within=False, mass={})
        prior = levels(self.problem.policy)
        level = self._levels[float(rng.choice([*prior], p=[*prior.values()]))]
        own = level.coloured(rng.standard_normal(len(self.problem.value)))
        value = self.problem.base + self.visibility.change(name, zeta) + own
        posterior = one_at_a_time(
            {k: each.read(value) for k, each in self._levels.items()}, self._before[name]
        )
        decision = decide(posterior, single=True)
        within = decision.answer == "cause" and name in decision.first
        mass: dict[str, float] = defaultdict(float)
        for p, fit in posterior.weighed:
            for each in self.problem.effects(fit.subset):
                mass[each] += p
        return RecoveryOutcome(within and decision.first == (name,), within, dict(mass))


@dataclass(frozen=True, eq=False)
class Hidden:
    """A cause at strengths from its prior.

    Attributes:
        trial: of the readings.
        cause: the effect.
    """

    trial: RecoveryTrial
    cause: Cause
    _drawn: dict[int, list[RecoveryOutcome]] = field(default_factory=dict)

    @cached_property
    def strengths(self) -> np.ndarray:
        """Strengths that are hidden, by the ordinary one, rising, shape (strengths,)."""
        first = next(each for each in self.cause.numbers if each.amplitude)
        middles = ndtri((np.arange(ADDITIONS.strengths) + 0.5) / ADDITIONS.strengths)
        values = first.at(middles)
        start, step = start_and_step(self.cause, first)
        return np.asarray(np.sort(np.abs(values - start) / abs(step)))

    @property
    def label(self) -> str:
        """Numbers of the cause at the ordinary strength, for people."""
        at = zip(self.cause.numbers, self.at(1.0), strict=True)
        return ", ".join(f"{n.key.rpartition('.')[2]} = {float(n.at(z)):.4g}" for n, z in at)

    def at(self, strength: float, rng: np.random.Generator | None = None) -> np.ndarray:
        """ζ of its numbers at a strength; those of its shape from their priors, or their middles.

        Args:
            strength: by the ordinary one.
            rng: draws the shape; None for the middles.
        """
        box = self.trial.problem.boxes[self.cause.name]
        return at_strength(self.cause, box, strength, rng)

    def drawn(self, place: int) -> list[RecoveryOutcome]:
        """The draws at one of the strengths."""
        if place not in self._drawn:
            name, strength = self.cause.name, float(self.strengths[place])
            found = []
            for turn in range(ADDITIONS.noises):
                rng = np.random.default_rng([zlib.crc32(name.encode()), place, turn])
                found.append(self.trial.diagnosed(name, self.at(strength, rng), rng))
            self._drawn[place] = found
        return self._drawn[place]

    def counted(
        self, counts: Callable[[RecoveryOutcome], bool], full: int = ADDITIONS.strengths
    ) -> np.ndarray:
        """How many draws are judged so at each strength, shape (strengths,).

        Not all are drawn: where none is, none is at a lower strength; where all are, all are at a
        higher one.

        Args:
            counts: of a draw.
            full: place from which on all are known to be.
        """
        count = np.full(ADDITIONS.strengths, ADDITIONS.noises)

        def look(low: int, high: int, place: int) -> None:
            if low >= high:
                return
            count[place] = sum(counts(each) for each in self.drawn(place))
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


def namings(planned: Analysis[Any], before: Sequence[EffectOutlook] = ()) -> list[EffectOutlook]:
    """Find for each effect from which strength on it is named, the strongest first.

    Args:
        planned: the readings to be.
        before: of fewer readings: what these name more readings name, too.
    """
    trial = RecoveryTrial(planned)
    known = {each.effect: each for each in before}
    found = [_naming(trial, cause, known.get(name)) for name, cause in planned.effects.items()]
    found += [EffectOutlook(effect=name) for name in planned.unseen]
    return sorted(found, key=lambda each: -each.strength_sigma)


def share(found: Sequence[EffectOutlook]) -> float:
    """Part of the effects that is named, strengths from their priors."""
    return float(np.mean([each.share for each in found] or [0.0]))


def share_of_classes(found: Sequence[EffectOutlook]) -> float:
    """Part of the effects that is named at least within a set."""
    return float(np.mean([each.class_share for each in found] or [0.0]))


def _naming(trial: RecoveryTrial, cause: Cause, before: EffectOutlook | None) -> EffectOutlook:
    hidden = Hidden(trial, cause)
    noises = ADDITIONS.noises
    full = ADDITIONS.strengths if before is None or before.sure is None else before.sure
    alone = hidden.counted(lambda outcome: outcome.alone, full)
    # of an addition it is told what it names, not what it nearly does
    within = alone if before else hidden.counted(lambda outcome: outcome.within)
    named = threshold(hidden.strengths, alone)
    return EffectOutlook(
        effect=cause.name, ordinary=hidden.label,
        strength_sigma=trial.visibility.strength(cause.name, hidden.at(1.0)), named_from=named,
        named_from_sigma=None
        if named is None
        else trial.visibility.strength(cause.name, hidden.at(named)),
        class_from=threshold(hidden.strengths, within), share=float(alone.mean()) / noises,
        class_share=float(within.mean()) / noises, confused_with=() if before else _alike(hidden),
        sure=int(np.max(np.flatnonzero(alone < noises) + 1, initial=0)),
    )  # fmt: skip


def threshold(strengths: np.ndarray, count: np.ndarray) -> float | None:
    """The strength that leaves the fewest draws named below and not named above it.

    Args:
        strengths: rising, shape (k,).
        count: draws that are named at each, of ADDITIONS.noises, shape (k,).

    Returns:
        The geometric mean of the two strengths that it lies between; None where it lies above all.
    """
    missed = ADDITIONS.noises - count
    wrong = np.r_[0, np.cumsum(count)] + np.r_[np.cumsum(missed[::-1])[::-1], 0]
    # the highest of equals: what is told is not too little
    place = len(wrong) - 1 - int(np.argmin(wrong[::-1]))
    if place == len(strengths):
        return None
    return float(np.sqrt(strengths[max(place - 1, 0)] * strengths[place]))


def _alike(hidden: Hidden) -> tuple[str, ...]:
    """Effects nearly as probable as it, in the draws about the ordinary strength."""
    name = hidden.cause.name
    mass: dict[str, float] = defaultdict(float)
    away = np.abs(np.log(np.maximum(hidden.strengths, 1e-9)))
    for place in np.argsort(away, kind="stable")[:2]:
        for each in hidden.drawn(int(place)):
            for other, p in each.mass.items():
                mass[other] += p
    least = POLICY.rival * mass[name]
    others = sorted(mass, key=lambda each: -mass[each])
    return tuple(each for each in others if each != name and mass[each] > least)

"""Which effects a diagnosis would name, at which strength, and with which it confuses them.

Each effect is hidden in turn: the readings are exactly what it makes of them, and are searched and
decided as measured ones are, one cause at a time. Its strength is found by halving from which on
the answer is this effect alone, or a set of effects that has it. The share of cases in which it is
named is the prior's probability of such strengths.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import scipy.linalg
from scipy.special import ndtri

from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.evidence import Case
from dolfingrip.diagnosis.core.numbers import Cause, UnknownNumber
from dolfingrip.diagnosis.core.search import Posterior, search
from dolfingrip.diagnosis.finger.unknowns import neutral
from dolfingrip.diagnosis.plan.case import PlannedCase
from dolfingrip.diagnosis.policy import POLICY

STRENGTHS: Final = 8
"""Strengths of an effect that may be tried: the middles of so many parts of the prior of the same
probability."""


@dataclass(frozen=True)
class Naming:
    """What the readings say about one effect.

    Attributes:
        effect: its name.
        ordinary: its parameters at the ordinary strength.
        strength_sigma: length of its change at the ordinary strength, nuisances fitted.
        named_from: least strength, by the ordinary one, from which on it is named alone; None where
            none that occurs is enough.
        named_from_sigma: the same in standard deviations.
        class_from: least strength from which on a set of effects with it is named.
        share: probability that a strength from the prior is named alone.
        class_share: that a set with it is.
        confused_with: effects that are as probable as it at the ordinary strength, or nearly so.
    """

    effect: str
    ordinary: str
    strength_sigma: float
    named_from: float | None
    named_from_sigma: float | None
    class_from: float | None
    share: float
    class_share: float
    confused_with: tuple[str, ...]

    @property
    def at_ordinary(self) -> bool:
        """Whether it is named at its ordinary strength."""
        return self.named_from is not None and self.named_from <= 1.0


def namings(planned: PlannedCase, before: Mapping[str, Naming] | None = None) -> list[Naming]:
    """Of each effect, the strongest first.

    Args:
        planned: the readings to be.
        before: of fewer readings, which more do not make worse: what these name stays named.
    """
    told = before or {}
    found = [
        _naming(planned, cause, told.get(name)) for name, cause in planned.causes.items()
    ] + [
        Naming(name, "", 0.0, None, None, None, 0.0, 0.0, ()) for name in planned.unseen
    ]  # fmt: skip
    return sorted(found, key=lambda each: -each.strength_sigma)


def share(found: Sequence[Naming]) -> float:
    """Part of the effects that is named, strengths from their priors."""
    return float(np.mean([each.share for each in found] or [0.0]))


def share_of_classes(found: Sequence[Naming]) -> float:
    """Part of the effects that is named at least within a set."""
    return float(np.mean([each.class_share for each in found] or [0.0]))


def _naming(planned: PlannedCase, cause: Cause, before: Naming | None) -> Naming:
    hiding = Hiding(planned, cause)
    sigma = strength(planned.case, cause.name, hiding.at(1.0))
    alone = _least(hiding, 0, None if before is None else before.share)
    # of an addition it is told what it names, not what it nearly does
    whole = _least(hiding, 1, None) if before is None else alone
    named, of_class = (
        None if k == STRENGTHS else float(hiding.strengths[k]) for k in (alone, whole)
    )
    named_sigma = None
    if named is not None:
        named_sigma = strength(planned.case, cause.name, hiding.at(named))
    return Naming(
        cause.name, hiding.label, sigma, named, named_sigma, of_class,
        1 - alone / STRENGTHS, 1 - whole / STRENGTHS, () if before else hiding.alike(),
    )  # fmt: skip


@dataclass(eq=False)
class Hiding:
    """An effect that is hidden at several strengths.

    Attributes:
        planned: the readings.
        cause: the effect.
        strengths: that occur, by the ordinary one, rising, shape (STRENGTHS,).
    """

    planned: PlannedCase
    cause: Cause
    strengths: np.ndarray = field(init=False)
    _told: dict[int, tuple[bool, bool]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        first = self._amplitudes[0]
        middles = ndtri((np.arange(STRENGTHS) + 0.5) / STRENGTHS)
        values = np.array([first.prior.at(z) for z in middles])
        start, step = _start_and_step(self.cause, first)
        self.strengths = np.sort(np.abs(values - start) / abs(step))

    @property
    def _amplitudes(self) -> list[UnknownNumber]:
        return [each for each in self.cause.numbers if each.amplitude]

    @property
    def label(self) -> str:
        """Its numbers at the ordinary strength, for people."""
        at = zip(self.cause.numbers, self.at(1.0), strict=True)
        return ", ".join(f"{n.key.rpartition('.')[2]} = {float(n.at(z)):.4g}" for n, z in at)

    def at(self, strength: float) -> np.ndarray:
        """ζ of its numbers at a strength; those of its shape are at the middle of their priors."""
        found = []
        for number, (low, high) in zip(
            self.cause.numbers, self.planned.case.boxes[self.cause.name], strict=True
        ):
            zeta = 0.0
            if number.amplitude:
                start, step = _start_and_step(self.cause, number)
                value = start + strength * step
                positive = number.prior.positive and value <= 0
                zeta = low if positive else number.prior.zeta(value)
            found.append(np.clip(zeta, low, high))
        return np.array(found)

    def named(self, place: int) -> tuple[bool, bool]:
        """Whether it is named alone, and whether a set with it is, at one of the strengths."""
        if place not in self._told:
            zeta = self.at(float(self.strengths[place]))
            decision = decide(_searched(self.planned.hidden(self.cause.name, zeta)), single=True)
            within = decision.answer == "cause" and self.cause.name in decision.first
            self._told[place] = within and len(decision.first) == 1, within
        return self._told[place]

    def alike(self) -> tuple[str, ...]:
        """Effects nearly as probable as it where it has its ordinary strength."""
        posterior = _searched(self.planned.hidden(self.cause.name, self.at(1.0)))
        mass: dict[str, float] = {}
        for p, fit in zip(posterior.probability, posterior.fits, strict=True):
            for name in posterior.case.effects(fit.subset):
                mass[name] = mass.get(name, 0.0) + float(p)
        least = POLICY.rival * mass.get(self.cause.name, 0.0)
        others = sorted(mass, key=lambda name: -mass[name])
        return tuple(name for name in others if name != self.cause.name and mass[name] >= least)


def _searched(case: Case) -> Posterior:
    return search(case, np.random.default_rng(0), sample=False, quick=True)


def _least(hiding: Hiding, kind: int, share_before: float | None) -> int:
    """Place of the least strength that is named, by halving; STRENGTHS where none is."""
    low, high = 0, STRENGTHS
    if share_before is not None:
        high = STRENGTHS - round(share_before * STRENGTHS)
    while low < high:
        middle = (low + high) // 2
        if hiding.named(middle)[kind]:
            high = middle
        else:
            low = middle + 1
    return low


def _start_and_step(cause: Cause, number: UnknownNumber) -> tuple[float, float]:
    """The value at which an amplitude does nothing, and from there to the ordinary one."""
    start = neutral(cause, number)
    step = number.prior.mean - start
    if abs(step) <= 1e-9 * number.prior.spread:
        step = number.prior.spread if number.bounds[1] > start else -number.prior.spread
    return start, step


def strength(case: Case, name: str, zeta: np.ndarray) -> float:
    """Length of a cause's change, the model's own numbers left free, standard deviations."""
    none = np.zeros(case.own)
    plain = case.predicted((), none)
    columns = [case.predicted((name,), np.r_[none, zeta]) - plain]
    step = 1e-3
    columns += [(case.predicted((), step * way) - plain) / step for way in np.eye(case.own)]
    lower = scipy.linalg.cholesky(case.covariance, lower=True)
    white = scipy.linalg.solve_triangular(lower, np.column_stack(columns), lower=True)
    change, free = white[:, 0], white[:, 1:]
    # as much as their priors let these follow
    pull = np.linalg.solve(free.T @ free + np.eye(free.shape[1]), free.T @ change)
    return float(np.sqrt(max(change @ (change - free @ pull), 0.0)))

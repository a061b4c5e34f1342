"""Which effects a diagnosis would name, at which strength, and with which it confuses them.

Each effect is hidden in turn, at strengths from its prior. The readings that it makes, with noise,
the rig's own errors and a discrepancy as probable as a diagnosis takes it to be, are searched and
decided as measured ones are, one cause at a time. The share of draws in which the answer is this
effect alone is the probability that it is named.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from dolfingrip.diagnosis.answer.analysed import Analysed
from dolfingrip.diagnosis.core.numbers import Cause
from dolfingrip.diagnosis.plan.hiding import Hidden, Judge
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY
from dolfingrip.files.plan import EffectOutlook


def namings(planned: Analysed[Any], before: Sequence[EffectOutlook] = ()) -> list[EffectOutlook]:
    """Of each effect, the strongest first.

    Args:
        planned: the readings to be.
        before: of fewer readings: what these name more readings name, too.
    """
    judge = Judge(planned)
    known = {each.effect: each for each in before}
    found = [_naming(judge, cause, known.get(name)) for name, cause in planned.causes.items()]
    found += [EffectOutlook(effect=name) for name in planned.unseen]
    return sorted(found, key=lambda each: -each.strength_sigma)


def share(found: Sequence[EffectOutlook]) -> float:
    """Part of the effects that is named, strengths from their priors."""
    return float(np.mean([each.share for each in found] or [0.0]))


def share_of_classes(found: Sequence[EffectOutlook]) -> float:
    """Part of the effects that is named at least within a set."""
    return float(np.mean([each.class_share for each in found] or [0.0]))


def _naming(judge: Judge, cause: Cause, before: EffectOutlook | None) -> EffectOutlook:
    hidden = Hidden(judge, cause)
    noises = ADDITIONS.noises
    full = ADDITIONS.strengths if before is None or before.sure is None else before.sure
    alone = hidden.counted(lambda judged: judged.alone, full)
    # of an addition it is told what it names, not what it nearly does
    within = alone if before else hidden.counted(lambda judged: judged.within)
    named = threshold(hidden.strengths, alone)
    return EffectOutlook(
        effect=cause.name, ordinary=hidden.label,
        strength_sigma=judge.strength(cause.name, hidden.at(1.0)), named_from=named,
        named_from_sigma=None
        if named is None
        else judge.strength(cause.name, hidden.at(named)),
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

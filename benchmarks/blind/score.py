"""Figures of many cases, each compared with what exact evidence attains on these cases."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import beta

from benchmarks.blind.opinions import Judged, Opinion

CLAIM: Final = 0.9
INVISIBLE_SIGMA: Final = 1.0
"""Strength below which a cause is counted apart."""
SEEN_SIGMA: Final = 6.0
STRONG_SIGMA: Final = 12.0
RICHEST: Final = ("P7+", "short-P7+")
"""The protocols with unloading, cycles and tip."""
CUTS: Final = 0.2
"""Least cut of the true model's from which cuts are compared."""

Right = Callable[[Judged, Opinion], bool]


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure.

    Attributes:
        name: what is counted.
        target: what is wanted, in words.
        value, bound: of the analyser and of exact evidence; NaN where there are no cases.
        count: number of cases.
        low, high: 90 % interval of the value (Clopper and Pearson 1934 for shares).
        met: whether the target is met; None where there are no cases.
    """

    name: str
    target: str
    value: float
    bound: float
    count: int
    low: float
    high: float
    met: bool | None


def interval(hits: int, count: int) -> tuple[float, float]:
    """Central 90 % interval of a share, by Clopper and Pearson."""
    if not count:
        return float("nan"), float("nan")
    low = 0.0 if hits == 0 else float(beta.ppf(0.05, hits, count - hits + 1))
    high = 1.0 if hits == count else float(beta.ppf(0.95, hits + 1, count - hits))
    return low, high


def share(
    name: str,
    target: str,
    cases: Sequence[Judged],
    right: Right,
    met: Callable[[float, float], bool],
) -> Figure:
    """The share of cases in which an opinion is right, and the bound's."""
    if not cases:
        nan = float("nan")
        return Figure(name, target, nan, nan, 0, nan, nan, None)
    hits = sum(right(case, case.said) for case in cases)
    best = sum(right(case, case.bound) for case in cases) / len(cases)
    value = hits / len(cases)
    return Figure(
        name, target, value, best, len(cases), *interval(hits, len(cases)), met(value, best)
    )


def at_least(level: float) -> Callable[[float, float], bool]:
    """A target for the value alone."""
    return lambda value, bound: value >= level


def at_most(level: float) -> Callable[[float, float], bool]:
    """A target for figures that should be small."""
    return lambda value, bound: value <= level


def of_bound(part: float) -> Callable[[float, float], bool]:
    """A target by the bound."""
    return lambda value, bound: value >= part * bound


def _named(case: Judged, opinion: Opinion) -> bool:
    return opinion.names(case.hidden[0])


def _something(case: Judged, opinion: Opinion) -> bool:
    return opinion.answer != "none"


def figures(cases: Sequence[Judged]) -> list[Figure]:
    """All figures of a set."""
    ones = [case for case in cases if case.kind == "one"]
    visible = [case for case in ones if case.sigma >= INVISIBLE_SIGMA]
    rich = [case for case in ones if case.protocol in RICHEST]
    found = [
        share("class named first, visible single effects", "0.95 of the bound", visible, _named,
              of_bound(0.95)),
        share("answered with the hidden cause's class, visible single effects", "0.95 of the bound",
              visible, lambda case, opinion: opinion.right(case.hidden), of_bound(0.95)),
        share("class named first, invisible ones", "", [c for c in ones if c not in visible],
              _named, lambda value, bound: True),
        share("class named first on P7+, 6 to 12 σ", "0.85",
              [c for c in rich if SEEN_SIGMA <= c.sigma < STRONG_SIGMA], _named, at_least(0.85)),
        share("class named first on P7+, from 12 σ", "0.95",
              [c for c in rich if c.sigma >= STRONG_SIGMA], _named, at_least(0.95)),
        *_claims(cases),
        share("false alarms where there is no cause", "at most 0.05",
              [c for c in cases if c.kind == "none"], _something, at_most(0.05)),
        share("detection from 6 σ", "0.95",
              [c for c in cases if c.kind != "none" and c.sigma >= SEEN_SIGMA], _something,
              at_least(0.95)),
        share("outsiders from 6 σ unexplained called unknown", "0.90",
              [c for c in cases if c.kind == "outsider" and c.unexplained_sigma >= SEEN_SIGMA],
              lambda case, opinion: opinion.answer == "unknown", at_least(0.9)),
        share("ties not named by one member", "0.95", [c for c in ones if c.tied],
              lambda case, opinion: not (opinion.claims(0) and len(opinion.named[0]) == 1),
              at_least(0.95)),
        _coverage(cases),
        _cut(cases),
        _rivals([c.beats_rivals for c in ones if c.said.right(c.hidden)]),
    ]  # fmt: skip
    return found


def _claims(cases: Sequence[Judged]) -> list[Figure]:
    """How often a cause is named with certainty, and how often that is right.

    Causes outside the catalogue are counted apart, where exact evidence is misled, too.
    """
    known = [case for case in cases if case.kind != "outsider"]
    made = share(
        f"claims with P ≥ {CLAIM}", "0.9 of the bound's", known,
        lambda case, opinion: opinion.claims(CLAIM), of_bound(0.9),
    )  # fmt: skip
    own = [case for case in known if case.said.claims(CLAIM)]
    best = [case for case in known if case.bound.claims(CLAIM)]
    right = share(
        "of these right", "0.97", own, lambda case, opinion: opinion.right(case.hidden),
        at_least(0.97),
    )  # fmt: skip
    exact = _mean([case.bound.right(case.hidden) for case in best])
    return [made, Figure(right.name, right.target, right.value, exact, right.count, right.low,
                         right.high, right.met)]  # fmt: skip


def _coverage(cases: Sequence[Judged]) -> Figure:
    inside = [each.covers for case in cases for each in case.intervals]
    exact = [each.covers for case in cases for each in case.bound_intervals]
    value = _mean(inside)
    low, high = interval(sum(inside), len(inside))
    return Figure(
        "90 % intervals that hold the truth", "0.85 to 0.95", value,
        _mean(exact), len(inside), low, high,
        0.85 <= value <= 0.95 if inside else None,
    )  # fmt: skip


def _cut(cases: Sequence[Judged]) -> Figure:
    """How much of the error on readings left out is cut, by what the true model cuts."""
    pairs = [
        (case.cut, case.bound_cut)
        for case in cases
        if case.cut is not None and case.bound_cut is not None and case.bound_cut >= CUTS
    ]
    own, best = (_mean([pair[i] for pair in pairs]) for i in (0, 1))
    nan = float("nan")
    return Figure(
        "error on readings left out is cut by", "0.8 of the bound", own, best, len(pairs), nan, nan,
        own >= 0.8 * best if pairs else None,
    )  # fmt: skip


def _rivals(told: Sequence[bool | None]) -> Figure:
    known = [each for each in told if each is not None]
    low, high = interval(sum(known), len(known))
    return Figure(
        "rivals lose to causes that are named rightly", "", _mean(known), float("nan"),
        len(known), low, high, True if known else None,
    )  # fmt: skip


def _mean(values: Sequence[float]) -> float:
    """Not a number where there are none."""
    return float(np.mean(values)) if values else float("nan")

"""The verdict: the cause, none, or an unknown one, with the classes that cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.blind.exact.pairs import PairScores
from benchmarks.blind.exact.posterior import Posterior
from benchmarks.blind.exact.thresholds import Thresholds
from dolfingrip.diagnosis.inference.classes import cosines, cosines_beside, partition
from dolfingrip.diagnosis.inference.screen import Score, Screen

Answer = Literal["cause", "none", "unknown"]

REFUTED = 0.001
"""Probability by the leading effect's below which an effect has no part in its class: the readings
speak against it, or strength and sign by its prior. So little, as many priors are guesses: a
strength at three of their standard deviations alone refutes nothing."""

SECOND = 3.0
"""Odds of two classes together, against the leading one alone, above which a second one is named
("positive evidence", Kass and Raftery 1995)."""

LIKELY = 0.5
"""Probability above which a class is named alone. What is less likely than not is no cause: further
classes are named with it, the next probable first, until one of all these is likely."""


@dataclass(frozen=True)
class EffectClass:
    """Effects that the readings cannot tell apart at the strength of the leading one.

    Attributes:
        names: of the effects, the most probable first.
        probability: that one of them takes part, alone or in a pair.
        members: probability of each alone, in the order of ``names``.
        strength_sigma: length of the leading one's fitted change, in standard deviations.
    """

    names: tuple[str, ...]
    probability: float
    members: tuple[float, ...]
    strength_sigma: float


@dataclass(frozen=True)
class Verdict:
    """What is wrong with the simulation.

    Attributes:
        answer: ``cause``, ``none`` or ``unknown``.
        named: the classes that are the cause: one, or two where two effects act together.
        probability: that the answer is right, of what is named where it is a cause.
        table: all classes of visible effects, the most probable first.
        none, unknown: probability of no cause, of an unknown one.
        log_odds_something, log_odds_unknown: what the thresholds were compared with.
        scores: of each candidate alone, in the order given.
        notes: what to beware of, a sentence each.
    """

    answer: Answer
    named: tuple[EffectClass, ...]
    probability: float
    table: tuple[EffectClass, ...]
    none: float
    unknown: float
    log_odds_something: float
    log_odds_unknown: float
    scores: tuple[Score, ...]
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all effects in the classes that are named."""
        return tuple(name for found in self.named for name in found.names)

    def sentence(self) -> str:
        """The verdict in words."""
        chance = f"probability {self.probability:.2f}"
        if self.answer == "none" and self.probability < 0.5:
            return (
                f"no cause can be claimed (probability of none {self.probability:.2f}); readings "
                "without a cause have such odds too often"
            )
        if self.answer == "none":
            return f"no cause can be seen ({chance})"
        if self.answer == "unknown":
            return f"the cause is none of the catalogue's effects ({chance})"
        causes = " together with ".join(" or ".join(found.names) for found in self.named)
        tied = any(len(found.names) > 1 for found in self.named)
        return f"the cause is {causes} ({chance})" + (
            "; these readings cannot tell them apart" if tied else ""
        )


def decide(
    posterior: Posterior,
    screen: Screen,
    scores: Sequence[Score],
    pairs: PairScores,
    thresholds: Thresholds,
) -> Verdict:
    """The verdict from probabilities.

    No cause is the answer unless the log odds of anything exceed their threshold, an unknown cause
    where its log odds exceed theirs. A cause is two classes where the leading pair of classes is
    :data:`SECOND` times as probable as the leading class alone. Classes that are less likely than
    not are named as one, with as many others as make them likely.

    Args:
        posterior: probabilities of the hypotheses.
        screen: of the candidates.
        scores: of the candidates, in the same order.
        pairs: of the visible candidates.
        thresholds: in log odds.
    """
    table = _table(posterior, screen, scores)
    something, unknown = posterior.log_odds_something(), posterior.log_odds_unknown()
    named: tuple[EffectClass, ...] = ()
    answer: Answer
    if something <= thresholds.something:
        answer, probability = "none", posterior.none
    elif unknown > thresholds.unknown or not table:
        answer, probability = "unknown", posterior.any_unknown
    else:
        answer = "cause"
        named, probability = _cause(posterior, screen, scores, pairs, table[0])
        if probability <= LIKELY:
            named = (_likely(posterior, scores, table),)
            probability = named[0].probability
    return Verdict(
        answer=answer,
        named=named,
        probability=probability,
        table=table,
        none=posterior.none,
        unknown=posterior.any_unknown,
        log_odds_something=something,
        log_odds_unknown=unknown,
        scores=tuple(scores),
        notes=tuple(note for score in scores for note in score.notes),
    )


def _table(
    posterior: Posterior, screen: Screen, scores: Sequence[Score]
) -> tuple[EffectClass, ...]:
    """Classes of the effects by what they explain alone."""
    visible = [int(i) for i in np.flatnonzero(screen.visible)]
    if not visible:
        return ()
    alone = posterior.singles
    leader = max(visible, key=lambda i: alone[i])
    strength = scores[leader].strength_sigma
    alive = [i for i in visible if alone[i] >= REFUTED * alone[leader]]
    rest = [i for i in visible if i not in alive]
    cosine = cosines(scores, _one_sided(screen))
    groups = partition(cosine, strength, alive) + partition(cosine, strength, rest)
    found = [_class(group, posterior, scores, posterior.with_either(group)) for group in groups]
    return tuple(sorted(found, key=lambda entry: -entry.probability))


def _cause(
    posterior: Posterior,
    screen: Screen,
    scores: Sequence[Score],
    pairs: PairScores,
    leading: EffectClass,
) -> tuple[tuple[EffectClass, ...], float]:
    """The classes that are the cause, and the probability that they are."""
    single = (leading,), leading.probability
    if not posterior.pairs.any():
        return single
    e, f = (int(i) for i in np.unravel_index(posterior.pairs.argmax(), posterior.pairs.shape))
    row = np.flatnonzero((pairs.members == (e, f)).all(axis=1))
    strength = float(pairs.strength_sigma[row[0]].min()) if len(row) else 0.0
    groups = [
        _tied_beside(one, other, strength, posterior, screen, scores)
        for one, other in ((e, f), (f, e))
    ]
    together = posterior.with_both(*groups)
    if together <= SECOND * sum(leading.members):
        return single
    if set(groups[0]) & set(groups[1]):
        # what may be either is one class
        union = sorted({*groups[0], *groups[1]})
        found = _class(union, posterior, scores, posterior.with_either(union))
        return (found,), found.probability
    named = [_class(group, posterior, scores, posterior.with_either(group)) for group in groups]
    return tuple(sorted(named, key=lambda entry: -entry.probability)), together


def _likely(
    posterior: Posterior, scores: Sequence[Score], table: Sequence[EffectClass]
) -> EffectClass:
    """The fewest classes, the most probable first, of which one is likely; else all of them."""
    place = {score.name: i for i, score in enumerate(scores)}
    group: list[int] = []
    for entry in table:
        group += [place[name] for name in entry.names]
        if posterior.with_either(group) > LIKELY:
            break
    return _class(group, posterior, scores, posterior.with_either(group))


def _tied_beside(
    one: int,
    other: int,
    strength: float,
    posterior: Posterior,
    screen: Screen,
    scores: Sequence[Score],
) -> tuple[int, ...]:
    """Candidates that could stand in place of ``one`` beside ``other``."""
    partners = (posterior.pairs + posterior.pairs.T)[other]
    alive = [i for i in range(len(partners)) if partners[i] >= REFUTED * partners[one]]
    candidate = screen.candidates[other]
    length = screen.length[np.flatnonzero(screen.owner == other)[scores[other].shape]]
    tau = float(length * np.hypot(candidate.spread, candidate.mean))
    cosine = cosines_beside(scores, _one_sided(screen), other, tau)
    among = [i for i in alive if i != other]
    return next(group for group in partition(cosine, strength, among) if one in group)


def _class(
    group: Sequence[int], posterior: Posterior, scores: Sequence[Score], probability: float
) -> EffectClass:
    order = sorted(group, key=lambda i: -posterior.singles[i])
    return EffectClass(
        names=tuple(scores[i].name for i in order),
        probability=probability,
        members=tuple(float(posterior.singles[i]) for i in order),
        strength_sigma=scores[order[0]].strength_sigma,
    )


def _one_sided(screen: Screen) -> np.ndarray:
    return np.array([candidate.one_sided for candidate in screen.candidates], dtype=bool)

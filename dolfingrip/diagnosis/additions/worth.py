"""What a proposed experiment would tell about effects that are tied, per minute.

If effect e is there as fitted, fitting f in its place leaves about ½ Δᵀ C⁻¹ Δ in log likelihood, Δ
the difference of both fits and C the covariance with f's own parameters free: the expected log
Bayes factor. An addition is worth what it adds, over the readings so far and its own together.

A law of many parameters follows whatever one of few does, so no readings tell them apart in this
way. But its evidence falls, as ever fewer of the values that were possible before remain. So e is
told from f, too, where the odds against f rise to what refutes an effect in a verdict.

Along one loading at one rate a law with memory, fitted anew, follows any elastic law, which its
tangent does not tell. Such a pair counts as told apart where memory shows itself alone
(:mod:`dolfingrip.diagnosis.additions.memory`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt
import pandas as pd

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.additions.covariance import Covariance, Matrix, Vector
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.outcome import NextExperiment
from dolfingrip.diagnosis.policy import POLICY

TIED: Final = float(np.log(20.0))
"""Expected log Bayes factor below which two effects are not told apart."""

REFUTES: Final = float(np.log(1000.0))
"""Log odds from which on an effect is refuted."""

ENOUGH: Final = 20.0
"""Log Bayes factor beyond which more decides nothing more."""

MODEL_ERROR: Final = 0.01
"""Relative error of a finger's simulation at conditions that nothing was measured at: independent
between readings, so that no tie is split by less than a model can be trusted. A coupon has no mesh,
and the laboratory tells how far its force follows a law."""


class Fitted(Protocol):
    """What :class:`Expected` asks of a fit: its numbers as standard normal ones."""

    @property
    def zeta(self) -> Vector: ...


@dataclass(frozen=True)
class Expected:
    """What is expected of readings if the row's effect is there, of the column's against it.

    Attributes:
        misfit: log likelihood that the column's effect falls short by.
        log_odds: log evidence that it does.
    """

    misfit: Matrix
    log_odds: Matrix

    @classmethod
    def of(
        cls,
        fits: Sequence[Fitted],
        covariance: Covariance,
        found: Sequence[tuple[Vector, Matrix]],
    ) -> Expected:
        """From the readings of each fit, and their derivatives."""
        misfit = np.zeros((len(found), len(found)))
        evidence = np.zeros_like(misfit)
        for j, ((other, slopes), fit) in enumerate(zip(found, fits, strict=True)):
            own = covariance.widened(slopes)
            scatter = float((own.whiten(covariance.factor) ** 2).sum())
            for i, (true, _) in enumerate(found):
                white = own.whiten(np.column_stack([true - other, slopes @ fit.zeta]))
                misfit[i, j] = 0.5 * float(white[:, 0] @ white[:, 0])
                left = white.sum(axis=1)
                evidence[i, j] = -0.5 * (own.logdet + scatter + float(left @ left))
        return cls(misfit, np.diag(evidence)[:, None] - evidence)


def chance_alone(
    probability: Vector, now: Expected, then: Expected, unseen: npt.NDArray[np.bool_]
) -> float:
    """Probability that the true effect is left alone.

    Args:
        probability: of each effect so far.
        now, then: without and with an addition.
        unseen: pairs that differ in what the readings do not show, shape (effects, effects).
    """
    log = np.log(probability)
    odds = log[:, None] - log[None, :] + then.log_odds - now.log_odds
    apart = (then.misfit > TIED) | (odds > REFUTES)
    apart = (apart & ~unseen) | np.eye(len(log), dtype=bool)
    return float(probability[apart.all(axis=1)].sum() / probability.sum())


@dataclass(frozen=True, eq=False)
class Tied:
    """A hypothesis that others are tied with.

    Attributes:
        zeta: its numbers as standard normal ones.
        readings, slopes: of a measurement, shapes (n,) and (n, d).
    """

    zeta: Vector
    readings: Vector
    slopes: Matrix


@dataclass(frozen=True, eq=False)
class Comparison:
    """Tied hypotheses by the readings so far.

    Attributes:
        probability: of each.
        here: each at the readings so far.
        now: what these are expected to tell.
    """

    probability: Vector
    here: Sequence[Tied]
    now: Expected

    @classmethod
    def of(
        cls, probability: Sequence[float], here: Sequence[Tied], covariance: Matrix
    ) -> Comparison:
        """By the covariance of the readings so far, shape (n, n)."""
        found = [(each.readings, each.slopes) for each in here]
        now = Expected.of(here, Covariance.of(covariance), found)
        return cls(np.array(probability), here, now)

    def worth(
        self,
        proposal: Proposal,
        after: Sequence[Tied],
        joint: Matrix,
        unseen: npt.NDArray[np.bool_] | None = None,
    ) -> NextExperiment:
        """What an addition is worth.

        Args:
            proposal: the addition.
            after: each hypothesis at the addition's readings.
            joint: covariance of the readings so far and of the addition's.
            unseen: pairs that differ in what the readings do not show; none by default.
        """
        together = [
            (np.append(a.readings, b.readings), np.vstack([a.slopes, b.slopes]))
            for a, b in zip(self.here, after, strict=True)
        ]
        then = Expected.of(self.here, Covariance.of(joint), together)
        weights = np.outer(self.probability, self.probability)
        np.fill_diagonal(weights, 0.0)
        weights /= max(weights.sum(), 1e-300)
        useful = np.minimum(then.misfit, ENOUGH) - np.minimum(self.now.misfit, ENOUGH)
        if unseen is None:
            unseen = np.zeros_like(weights, dtype=bool)
        return NextExperiment(
            name=proposal.name, minutes=proposal.minutes,
            gain=float((weights * (then.misfit - self.now.misfit)).sum()),
            gain_per_minute=float((weights * useful).sum() / proposal.minutes),
            chance=chance_alone(self.probability, self.now, then, unseen),
        )  # fmt: skip


def tied(posterior: Posterior, decision: Decision) -> list[tuple[float, Fit]]:
    """The hypotheses that could each be the answer, by their causes, the most probable first."""
    total: dict[tuple[str, ...], float] = {}
    named = {*decision.first, *decision.second}
    for p, fit in zip(posterior.probability, posterior.fits, strict=True):
        if named & set(fit.subset):
            total[fit.subset] = total.get(fit.subset, 0.0) + float(p)
    least = POLICY.rival * max(total.values(), default=0.0)
    likely = {subset: p for subset, p in total.items() if p > least}
    # two causes of which one is tied alone are the same answer
    alone = [
        (p, posterior.best(subset)) for subset, p in likely.items()
        if not any(set(other) < set(subset) for other in likely)
    ]  # fmt: skip
    return sorted(alone, key=lambda each: -each[0])[: POLICY.compared]


def usual_noise(measured: Measurement, noise: np.ndarray, other: Measurement) -> np.ndarray:
    """Noise of another measurement's readings: the median of their channel's so far.

    Args:
        measured: so far.
        noise: of its readings, shape (n,).
        other: whose readings are to be made.
    """
    by_column = pd.Series(noise).groupby(measured.listed()["column"].to_numpy()).median()
    columns = other.listed()["column"]
    return np.array([by_column.get(name, CHANNELS[name].noise) for name in columns])

"""What a proposed experiment would tell about effects that are tied, per minute.

If effect e is there as fitted, fitting f in its place leaves about ½ Δᵀ C⁻¹ Δ in log likelihood, Δ
the difference of both fits and C the covariance with f's own parameters free: the expected log
Bayes factor. An addition is worth what it adds, over the readings so far and its own together.

A law of many parameters follows whatever one of few does, so no readings tell them apart in this
way. But its evidence falls, as ever fewer of the values that were possible before remain. So e is
told from f, too, where the odds against f rise to what refutes an effect in a verdict.

Along one loading at one rate a law with memory, fitted anew, follows any elastic law, which its
tangent does not tell. Such a pair counts as told apart where memory shows itself alone
(:func:`shows_memory`).

Which further experiment would tell tied causes apart.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.linalg import cholesky, solve_triangular

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.problem import InferenceProblem
from dolfingrip.diagnosis.core.search import ModelPosterior
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY
from dolfingrip.files.diagnosis import NextExperiment


@dataclass(frozen=True, eq=False)
class Rival:
    """A hypothesis that others are tied with.

    Attributes:
        zeta: its numbers as standard normal ones, shape (d,).
        readings, slopes: of a measurement, shapes (n,) and (n, d).
    """

    zeta: np.ndarray
    readings: np.ndarray
    slopes: np.ndarray


PredictedAddition = tuple[Sequence[Rival], np.ndarray, float | np.ndarray, bool | np.ndarray]
"""What :meth:`Comparison.worth` asks of an addition: each hypothesis at its readings, covariances,
and which pairs do not show there what they differ in."""


@dataclass(frozen=True)
class Expected:
    """Expected readings if the row's effect acts, as evidence against the column's.

    Attributes:
        misfit: log likelihood that the column's effect falls short by.
        log_odds: log evidence that it does.
    """

    misfit: np.ndarray
    log_odds: np.ndarray

    @classmethod
    def of(cls, fits: Sequence[Rival], covariance: np.ndarray) -> Expected:
        """From the readings of each fit, whose covariance is of shape (n, n)."""
        factor = cholesky(covariance, lower=True)
        misfit = np.zeros((len(fits), len(fits)))
        evidence = np.zeros_like(misfit)
        for j, other in enumerate(fits):
            own = cholesky(covariance + other.slopes @ other.slopes.T, lower=True)
            off = np.column_stack([true.readings - other.readings for true in fits])
            pull = (other.slopes @ other.zeta)[:, None]
            white = solve_triangular(own, np.hstack([off, off + pull, factor]), lower=True)
            off, left, scatter = np.split(np.square(white).sum(axis=0), [len(fits), 2 * len(fits)])
            misfit[:, j] = 0.5 * off
            evidence[:, j] = -0.5 * (2 * np.log(np.diag(own)).sum() + scatter.sum() + left)
        return cls(misfit, np.diag(evidence)[:, None] - evidence)


def chance_alone(
    probability: np.ndarray, now: Expected, then: Expected, unseen: np.ndarray
) -> float:
    """Probability that the true effect is left alone.

    Args:
        probability: of each effect so far.
        now, then: without and with an addition.
        unseen: pairs that differ in what the readings do not show, shape (effects, effects) of
            bool.
    """
    log = np.log(probability)
    odds = log[:, None] - log[None, :] + then.log_odds - now.log_odds
    apart = (then.misfit > ADDITIONS.tied) | (odds > ADDITIONS.refutes)
    apart = (apart & ~unseen) | np.eye(len(log), dtype=bool)
    return float(probability[apart.all(axis=1)].sum() / probability.sum())


@dataclass(frozen=True, eq=False)
class Comparison:
    """Tied hypotheses by the readings so far.

    Attributes:
        measurement: so far.
        noise: of its readings, shape (n,).
        covariance: of its readings, shape (n, n).
        probability: of each hypothesis.
        here: each at the readings so far.
    """

    measurement: Measurement
    noise: np.ndarray
    covariance: np.ndarray
    probability: np.ndarray
    here: Sequence[Rival]

    @cached_property
    def now(self) -> Expected:
        """Expected evidence of the readings so far."""
        return Expected.of(self.here, self.covariance)

    def worth(
        self,
        proposal: Proposal,
        after: Sequence[Rival],
        shared: np.ndarray,
        cross: float | np.ndarray,
        unseen: bool | np.ndarray,
    ) -> NextExperiment:
        """Weigh what an addition tells by the time that it takes.

        Args:
            proposal: the addition.
            after: each hypothesis at the addition's m readings.
            shared: covariance of what these differ by together, shape (m, m).
            cross: covariance of the readings so far and these, shape (n, m).
            unseen: pairs that differ in what the readings do not show, shape (effects, effects);
                one value for all pairs will do.
        """
        n, listed = len(self.covariance), proposal.measurement.listed()
        error = np.where(
            listed["experiment"] == "coupon", ADDITIONS.law_error, ADDITIONS.model_error
        )
        noise = usual_noise(self.measurement, self.noise, proposal.measurement)
        own = np.diag(noise**2 + (error * after[0].readings) ** 2) + shared
        between = np.broadcast_to(cross, (n, len(own)))
        joint = np.block([[self.covariance, between], [between.T, own]])
        together = [
            Rival(a.zeta, np.append(a.readings, b.readings), np.vstack([a.slopes, b.slopes]))
            for a, b in zip(self.here, after, strict=True)
        ]
        then = Expected.of(together, joint)
        weights = np.outer(self.probability, self.probability)
        np.fill_diagonal(weights, 0.0)
        weights /= max(weights.sum(), 1e-300)
        useful = np.minimum(then.misfit, ADDITIONS.enough) - np.minimum(
            self.now.misfit, ADDITIONS.enough
        )
        return NextExperiment(
            name=proposal.name, minutes=proposal.minutes,
            gain=float((weights * (then.misfit - self.now.misfit)).sum()),
            gain_per_minute=float((weights * useful).sum() / proposal.minutes),
            chance=chance_alone(self.probability, self.now, then, np.asarray(unseen)),
        )  # fmt: skip


def tied(posterior: ModelPosterior, decision: Decision) -> list[tuple[float, MapFit]]:
    """The hypotheses that could each be the answer, by the named causes that act in them.

    The most probable first; of those in which the same named causes act the most probable one.
    """
    named = {*decision.first, *decision.second}
    fits: dict[frozenset[str], list[tuple[float, MapFit]]] = defaultdict(list)
    for p, fit in posterior.weighed:
        if acting := named.intersection(fit.subset):
            fits[frozenset(acting)].append((p, fit))
    total = {acting: sum(p for p, _ in own) for acting, own in fits.items()}
    least = POLICY.rival * max(total.values(), default=0.0)
    likely = [acting for acting, p in total.items() if p > least]
    # two causes of which one is tied alone are the same answer
    alone = [acting for acting in likely if not any(other < acting for other in likely)]
    alone.sort(key=lambda acting: -total[acting])
    return [
        (total[acting], max(fits[acting], key=lambda each: each[0])[1])
        for acting in alone[: POLICY.compared]
    ]


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


def shows_memory(*measurements: Measurement) -> bool:
    """Tell whether readings of the same experiments show what a material remembers.

    They do where something is unloaded or waits, or is loaded at two rates.
    """
    rates: dict[str, list[float]] = defaultdict(list)
    for measurement in measurements:
        for test in measurement.tests:
            rows = measurement.rows(test.number)
            if (rows["branch"] != "loading").any():
                return True
            rate = measurement.ramp_rate(test)
            if rate is not None:
                rates[test.experiment].append(rate)
    return any(max(own) > ADDITIONS.other_rate * min(own) for own in rates.values())


def next_experiments(
    posterior: ModelPosterior,
    decision: Decision,
    measurement: Measurement,
    config: Config,
    noise: np.ndarray,
    then: Callable[[Proposal, Sequence[MapFit]], PredictedAddition],
    say: Callable[[str], None],
) -> tuple[list[NextExperiment], list[str]]:
    """Additions that tell the tied hypotheses apart, the best first, and why some failed.

    Nothing where no other hypothesis is tied with the leading one.

    Args:
        posterior: of all hypotheses.
        decision: the answer.
        measurement: so far.
        config: the model that is diagnosed.
        noise: of the readings so far, shape (n,).
        then: of an addition, with the tied hypotheses; it may raise a ``ConfigError``.
        say: told what is being done.
    """
    likely = tied(posterior, decision)
    if len(likely) < 2:
        return [], []
    fits = [fit for _, fit in likely]
    comparison = Comparison(
        measurement, noise, posterior.problem.covariance, np.array([p for p, _ in likely]),
        [_here(posterior.problem, fit) for fit in fits],
    )  # fmt: skip
    found, failed = [], []
    for proposal in proposals(measurement, config):
        say(f"next experiment: {proposal.name}")
        try:
            after, shared, cross, unseen = then(proposal, fits)
        except ConfigError as error:
            failed.append(f"{proposal.name} could not be judged: {error}")
            continue
        if not all(np.isfinite(each.slopes).all() for each in after):
            failed.append(
                f"{proposal.name} could not be judged: a likely law has no equilibrium there"
            )
            continue
        found.append(comparison.worth(proposal, after, shared, cross, unseen))
    return sorted(found, key=lambda worth: worth.rank), failed


def _here(problem: InferenceProblem, fit: MapFit) -> Rival:
    """A hypothesis at the readings so far."""
    told = problem.predicted(fit.subset, fit.zeta)
    return Rival(fit.zeta, told, problem.slopes(fit.subset, fit.zeta))

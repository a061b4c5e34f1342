"""What a proposed experiment would tell about effects that are tied, per minute.

If effect e is there as fitted, fitting f in its place leaves about ½ Δᵀ C⁻¹ Δ in log likelihood, Δ
the difference of both fits and C the covariance with f's own parameters free: the expected log
Bayes factor. An addition is worth what it adds, over the readings so far and its own together.

A law of many parameters follows whatever one of few does, so no readings tell them apart in this
way. But its evidence falls, as ever fewer of the values that were possible before remain. So e is
told from f, too, where the odds against f rise to what refutes an effect in a verdict.

Along one loading at one rate a law with memory, fitted anew, follows any elastic law, which its
tangent does not tell. Such a pair counts as told apart where memory shows itself alone
(:func:`dolfingrip.diagnosis.data.measurement.shows_memory`).

Elastic laws stay together in a verdict until one of them misses a hundredth of the largest reading,
however many readings speak for the other; so they do here.

Which further experiment would tell tied causes apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.linalg import block_diag, cho_factor, cho_solve, cholesky, solve_triangular

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.additions.checks import NumberCheck
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.core.decision import LAW_MISSES, Decision
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.search import ModelPosterior
from dolfingrip.diagnosis.data.measurement import Measurement, largest
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.diagnosis import NextExperiment


@dataclass(frozen=True, eq=False)
class Rival:
    """A hypothesis that others are tied with.

    Attributes:
        zeta: its numbers as standard normal ones, shape (d,).
        readings, slopes: of a measurement, shapes (n,) and (n, d).
        acting: its causes, whose numbers come last.
        own: number of the model's own numbers, which come first.
        change: of the first readings by its causes, shape (m,); none where empty.
    """

    zeta: np.ndarray
    readings: np.ndarray
    slopes: np.ndarray
    acting: frozenset[str] = frozenset()
    own: int = 0
    change: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class Expected:
    """Expected readings if the row's effect acts, as evidence against the column's.

    Attributes:
        misfit: log likelihood that the column's effect falls short by.
        log_odds: log evidence that it does.
        nothing: whether the column's effect, which has more causes than the row's, would be left
            with too little to be seen.
        missed: root mean square of what the column's effect cannot follow, by the largest reading
            of each channel.
    """

    misfit: np.ndarray
    log_odds: np.ndarray
    nothing: np.ndarray
    missed: np.ndarray

    @classmethod
    def of(
        cls,
        fits: Sequence[Rival],
        covariance: np.ndarray,
        noise: np.ndarray | None = None,
        least: float = Policy().visible,
        columns: np.ndarray | None = None,
        alone: np.ndarray | None = None,
    ) -> Expected:
        """From the readings of each fit.

        Args:
            fits: the hypotheses.
            covariance: of the readings, shape (n, n).
            noise: of the readings so far, which come first; by the covariance where None.
            least: length of a change below which nothing can be seen.
            columns: channel of each reading, shape (n,), empty of one that is of no channel; all
                are of one where None.
            alone: standard deviation of each reading that no other shares, which a verdict leaves
                to what laws miss, shape (n,); by the covariance where None.
        """
        alone = np.sqrt(np.diag(covariance)) if alone is None else alone
        size = np.sqrt(np.diag(covariance)) if noise is None else noise
        factor = cholesky(covariance, lower=True)
        misfit = np.zeros((len(fits), len(fits)))
        evidence = np.zeros_like(misfit)
        missed = np.zeros_like(misfit)
        nothing = np.zeros(misfit.shape, dtype=bool)
        columns = np.full(len(covariance), "all") if columns is None else columns
        shown = columns != ""
        by = np.column_stack([largest(true.readings[shown], columns[shown]) for true in fits])
        true_readings = np.column_stack([true.readings for true in fits])
        for j, other in enumerate(fits):
            left, evidence[:, j] = expected_evidence(other, covariance, covariance, true_readings)
            off = true_readings - other.readings[:, None]
            missed[:, j] = np.sqrt(np.square((alone[:, None] ** 2 * left)[shown] / by).mean(axis=0))
            misfit[:, j] = 0.5 * (off * left).sum(axis=0)
            more = np.array([true.acting < other.acting for true in fits])
            nothing[:, j] = more & (_room(other, factor, size) < least)
        return cls(misfit, np.diag(evidence)[:, None] - evidence, nothing, missed)


def expected_evidence(
    rival: Rival, covariance: np.ndarray, scatter: np.ndarray, readings: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Evidence for a hypothesis that is expected where readings are those of others.

    All that it fits is linear about its numbers.

    Args:
        rival: the hypothesis.
        covariance: that it has for the readings, shape (n, n).
        scatter: that they have about what is expected of them, shape (n, n).
        readings: that are expected, shape (n, places).

    Returns:
        What it leaves of them by its whole covariance's inverse, (n, places), and ln p(y) but for
        a constant, (places,).
    """
    total = cho_factor(covariance + rival.slopes @ rival.slopes.T, lower=True)
    off = readings - rival.readings[:, None]
    from_prior = off + (rival.slopes @ rival.zeta)[:, None]
    pulled = (from_prior * cho_solve(total, from_prior)).sum(axis=0)
    volume = 2 * np.log(np.diag(total[0])).sum() + np.trace(cho_solve(total, scatter))
    return cho_solve(total, off), -0.5 * (volume + pulled)


def _room(rival: Rival, factor: np.ndarray, noise: np.ndarray) -> float:
    """The largest change by a hypothesis' causes that readings leave open, standard deviations.

    That of numbers which are known, such as gravity's, is left whatever is read.

    Args:
        rival: the hypothesis.
        factor: Cholesky factor of the readings' covariance, shape (n, n).
        noise: of the first readings, which count, shape (m,).
    """
    white = solve_triangular(factor, rival.slopes, lower=True)
    open_to = np.linalg.inv(white.T @ white + np.eye(white.shape[1]))[rival.own :, rival.own :]
    slopes = rival.slopes[: len(noise), rival.own :] / noise[:, None]
    change = rival.change / noise[: len(rival.change)]
    followed = slopes[: len(change)]
    inner = followed.T @ followed + np.eye(followed.shape[1])
    fixed = change - followed @ np.linalg.solve(inner, followed.T @ change)
    most = float(np.linalg.eigvals(open_to @ slopes.T @ slopes).real.max(initial=0.0))
    return float(np.sqrt(most + fixed @ fixed))


def told_apart(
    probability: np.ndarray,
    now: Expected,
    then: Expected,
    unseen: bool | np.ndarray = False,
    policy: Policy = Policy(),
) -> np.ndarray:
    """Tell if each column's effect is refuted where the row's acts, (effects, effects) of bool.

    Args:
        probability: of each effect so far.
        now, then: without and with an addition.
        unseen: pairs that differ in what the readings do not show, shape (effects, effects) of
            bool; one value for all will do.
        policy: what tells two of them apart.
    """
    log = np.log(probability)
    odds = log[:, None] - log[None, :] + then.log_odds - now.log_odds
    apart = (then.misfit > policy.log_odds) | (odds > np.log(1000)) | then.nothing
    return np.asarray((apart & ~np.asarray(unseen)) | np.eye(len(log), dtype=bool))


def chance_alone(probability: np.ndarray, apart: np.ndarray) -> float:
    """Probability that the true effect is left alone.

    Args:
        probability: of each effect so far.
        apart: which would be refuted, as :func:`told_apart` says.
    """
    return float(probability[apart.all(axis=1)].sum() / probability.sum())


@dataclass(frozen=True, eq=False)
class Comparison:
    """Tied hypotheses by the readings so far.

    Attributes:
        measurement: so far.
        noise: of its readings, shape (n,).
        covariance: of its readings, and of numbers that were read by themselves, (n + m, n + m).
        probability: of each hypothesis.
        here: each at the readings so far.
        policy: what tells two of them apart.
        elastic: causes that are elastic laws.
    """

    measurement: Measurement
    noise: np.ndarray
    covariance: np.ndarray
    probability: np.ndarray
    here: Sequence[Rival]
    policy: Policy = Policy()
    elastic: frozenset[str] = frozenset()

    @property
    def columns(self) -> np.ndarray:
        """Channel of each reading so far, empty of a number that was read by itself, (n + m,)."""
        listed = self.measurement.listed["column"].to_numpy()
        return np.append(listed, [""] * (len(self.covariance) - len(listed)))

    @cached_property
    def now(self) -> Expected:
        """Expected evidence of the readings so far."""
        least = self.policy.visible
        alone = self._alone
        return Expected.of(self.here, self.covariance, self.noise, least, self.columns, alone)

    @property
    def _alone(self) -> np.ndarray:
        """Standard deviation of each reading so far that no other shares, (n + m,)."""
        return np.append(self.noise, np.sqrt(np.diag(self.covariance))[len(self.noise) :])

    @cached_property
    def apart(self) -> np.ndarray:
        """Which are told apart already, (effects, effects) of bool."""
        return told_apart(self.probability, self.now, self.now, self._alike(self.now), self.policy)

    def _alike(self, expected: Expected) -> np.ndarray:
        """Which elastic laws would stay together in a verdict, (effects, effects) of bool."""
        laws = np.array([len(rival.acting & self.elastic) == 1 for rival in self.here])
        return (laws[:, None] & laws) & (expected.missed <= LAW_MISSES)

    def errors(self, proposal: Proposal, readings: np.ndarray) -> np.ndarray:
        """Covariance (m, m) of an addition's readings by noise and by what a model may be off.

        The noise is the median of a channel's so far. A model may be off by a hundredth where
        nothing was measured, independent between readings, so that no tie is split by less.
        """
        by_column = pd.Series(self.noise).groupby(self.columns[: len(self.noise)]).median()
        noise = np.array([by_column.get(name, CHANNELS[name].noise) for name in proposal.columns])
        return np.diag(noise**2 + (0.01 * readings) ** 2)

    def worth(
        self,
        addition: Proposal | NumberCheck,
        after: Sequence[Rival],
        errors: np.ndarray,
        others: float | np.ndarray = 0.0,
        unseen: bool | np.ndarray = False,
    ) -> NextExperiment:
        """Weigh what an addition tells by the time that it takes.

        Args:
            addition: what is measured.
            after: each hypothesis at the addition's m readings.
            errors: covariance of these readings by what no other shares, shape (m, m).
            others: that by all else that no hypothesis fits, shape (m, m).
            unseen: pairs that differ in what the readings do not show, shape (effects, effects);
                one value for all pairs will do.
        """
        joint = block_diag(self.covariance, errors + others)
        together = [
            replace(
                a,
                readings=np.append(a.readings, b.readings),
                slopes=np.vstack([a.slopes, b.slopes]),
            )
            for a, b in zip(self.here, after, strict=True)
        ]
        columns = np.append(self.columns, addition.columns)
        alone = np.append(self._alone, np.sqrt(np.diag(errors)))
        then = Expected.of(together, joint, self.noise, self.policy.visible, columns, alone)
        alike = self._alike(then)
        apart = told_apart(
            self.probability, self.now, then, np.asarray(unseen) | alike, self.policy
        )
        more = (then.misfit - self.now.misfit > self.policy.log_odds) & ~alike
        weights = np.outer(self.probability, self.probability)
        np.fill_diagonal(weights, 0.0)
        weights /= max(weights.sum(), 1e-300)
        enough = self.policy.hopeless
        useful = np.minimum(then.misfit, enough) - np.minimum(self.now.misfit, enough)
        return NextExperiment(
            name=addition.name, minutes=addition.minutes,
            tests=addition.tests, quantities=addition.quantities,
            gain=float((weights * (then.misfit - self.now.misfit)).sum()),
            gain_per_minute=float((weights * useful).sum() / addition.minutes),
            chance=chance_alone(self.probability, apart),
            excludes=self._names(apart[0] & ~self.apart[0]),
            shows=self._names((apart & ~self.apart | more)[:, 0]),
        )  # fmt: skip

    def _names(self, which: np.ndarray) -> tuple[str, ...]:
        return tuple(" with ".join(sorted(self.here[j].acting)) for j in np.flatnonzero(which))


def tied(posterior: ModelPosterior, decision: Decision) -> list[tuple[float, MapFit]]:
    """The hypotheses that could each be the answer, by the named causes that act in them.

    The most probable first; of those in which the same named causes act the most probable one.
    Causes with memory that readings tell by a shape alone may act though they are not named.
    """
    problem, policy = posterior.problem, posterior.problem.policy
    open_ = {*decision.first, *decision.second, *problem.remembering}

    def acting_in(fit: MapFit) -> frozenset[str]:
        return frozenset(open_.intersection(fit.subset))

    total = {acting: p for acting, p in posterior.by(acting_in).items() if acting}
    least = policy.matters * max(total.values(), default=0.0)
    # members of a set are the less probable ones, too
    members = {*decision.first} if len(decision.first) > 1 else set()
    likely = [acting for acting, p in total.items() if p > least or acting & members]
    # two causes of which one is tied alone are the same answer
    alone = [acting for acting in likely if not any(other < acting for other in likely)]
    alone.sort(key=lambda acting: -total[acting])
    leaders = posterior.leaders(acting_in)
    return [(total[acting], leaders[acting]) for acting in alone[: policy.leading]]

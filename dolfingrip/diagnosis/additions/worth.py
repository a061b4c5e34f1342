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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions import memory
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.classes import TIED
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.verdict import REFUTED
from dolfingrip.diagnosis.model import FitFailure
from dolfingrip.diagnosis.problem import AREA, MODULUS, Problem
from dolfingrip.diagnosis.simulation import meshes
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.simulation.nuisances import WALL, keys, neutral_stages, nuisances
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import Case, simulate

REFUTES: Final = -float(np.log(REFUTED))
"""Log odds from which on an effect is refuted."""

ENOUGH: Final = 20.0
"""Log Bayes factor beyond which more decides nothing more."""

ALONE: Final = 0.8
"""Probability of leaving the true effect alone from which on an addition is said to do so."""

MODEL_ERROR: Final = 0.01
"""Relative error of a finger's simulation at conditions that nothing was measured at: independent
between readings, so that no tie is split by less than a model can be trusted. A coupon has no mesh,
and the laboratory tells how far its force follows a law."""


@dataclass(frozen=True)
class AdditionWorth:
    """An addition, judged.

    Attributes:
        name, minutes: of it.
        gain: expected increase of the log Bayes factor, averaged over pairs of tied effects.
        gain_per_minute: the same up to what decides, by the minute.
        chance: probability that the true one of the tied effects is told from all others with it.
    """

    name: str
    minutes: float
    gain: float
    gain_per_minute: float
    chance: float

    @property
    def splits(self) -> bool:
        """Whether the true one is expected to be left alone."""
        return self.chance >= ALONE

    @property
    def rank(self) -> tuple[bool, float]:
        """Place in the order: the less, the earlier.

        Where the true effect is expected to be left alone, the minutes that this is expected to
        take count, as what is told beyond decides nothing; else what is told by the minute.
        """
        return not self.splits, self.minutes / self.chance if self.splits else -self.gain_per_minute


def judge(
    problem: Problem,
    tied: Sequence[tuple[Hypothesis, float]],
    proposals: Sequence[Proposal],
    workers: Workers,
    say: Callable[[str], None],
) -> tuple[list[AdditionWorth], list[str]]:
    """Additions, the best first (:attr:`AdditionWorth.rank`), and why some could not be judged.

    Args:
        problem: the readings so far.
        tied: fitted effects that they cannot tell apart, with their probabilities.
        proposals: what could be added.
        workers: where simulations are computed.
        say: told what is being done.
    """
    probability = np.array([p for _, p in tied])
    weights = np.outer(probability, probability)
    np.fill_diagonal(weights, 0.0)
    weights /= max(weights.sum(), 1e-300)
    fits = [fit for fit, _ in tied]
    now = Expected.of(fits, problem.covariance, [(f.readings, f.jacobian) for f in fits])
    found, failed = [], []
    for proposal in proposals:
        say(f"next experiment: {proposal.name}")
        try:
            then = _after(problem, fits, proposal, workers)
        except (FitFailure, ConfigError) as failure:
            failed.append(f"{proposal.name} could not be judged: {failure}")
            continue
        seen = memory.shows(problem.measurement, proposal.measurement)
        unseen = np.zeros_like(weights, dtype=bool) if seen else memory.differs(fits)
        before, after = now.misfit, then.misfit
        useful = np.minimum(after, ENOUGH) - np.minimum(before, ENOUGH)
        found.append(
            AdditionWorth(
                proposal.name,
                proposal.minutes,
                float((weights * (after - before)).sum()),
                float((weights * useful).sum() / proposal.minutes),
                chance_alone(probability, now, then, unseen),
            )
        )
    return sorted(found, key=lambda worth: worth.rank), failed


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


def _after(
    problem: Problem, fits: Sequence[Hypothesis], proposal: Proposal, workers: Workers
) -> Expected:
    """With the addition."""
    base = problem.base
    flat = () if proposal.known_mesh else meshes.ungraded(base.config)
    config = base.config.overridden(flat) if flat else base.config
    measurement = proposal.measurement
    listed = measurement.listed()
    nuisance = _own_nuisances(problem, proposal, config, workers)
    walls = nuisance.pop(WALL, None) if problem.wall else None
    found = []
    for fit in fits:
        own, jacobian = fitted_readings(fit, proposal, config, workers)
        if walls is not None:
            place = [each.key for each in fit.parameters].index(WALL)
            own, jacobian[:, place] = own + walls * fit.zeta[place], walls
        found.append((np.append(fit.readings, own), np.vstack([fit.jacobian, jacobian])))
    columns = _joined(problem, nuisance, len(listed))
    std = np.array([_noise_std(problem, str(column)) for column in listed["column"]])
    n = len(problem.value)
    std = np.hypot(std, _model_error(measurement) * np.abs(found[0][0][n:]))
    noise = np.zeros((n + len(std), n + len(std)))
    noise[:n, :n] = problem.error_covariance.matrix
    noise[n:, n:] = np.diag(std**2)
    return Expected.of(fits, Covariance.of(noise + columns @ columns.T), found)


def fitted_readings(
    fit: Hypothesis, proposal: Proposal, config: Config, workers: Workers
) -> tuple[Vector, Matrix]:
    """Readings of an addition as a fit has them, with derivatives by ζ."""
    if fit.beside is not None:
        return _with_linear(fit, fit.beside, proposal, config, workers)
    if fit.model is None:  # an effect that was not fitted
        raise FitFailure(f"{' with '.join(fit.effects)} cannot be simulated there")
    # the gap and the regulator's zero of an addition are others, not those that were fitted
    kept = fit.model.of_the_finger
    model = replace(
        fit.model, measurement=proposal.measurement, config=config, workers=workers,
        base=None, scales=False, count=0, wall=None, curves=None, shifts=(), _known={},
    )  # fmt: skip
    readings, own = model.evaluate([fit.values[i] for i in kept])
    slopes = np.zeros((len(readings), len(fit.parameters)))
    slopes[:, kept] = own
    by_zeta = [p.prior.slope(float(z)) for p, z in zip(fit.parameters, fit.zeta, strict=True)]
    return readings, slopes * np.array(by_zeta)


def _with_linear(
    fit: Hypothesis, beside: Hypothesis, proposal: Proposal, config: Config, workers: Workers
) -> tuple[Vector, Matrix]:
    """The same of effects that are linear: an instrument's are there with the same instruments."""
    first = len(beside.parameters)
    rest = replace(beside, zeta=fit.zeta[:first])
    readings, slopes = fitted_readings(rest, proposal, config, workers)
    base = simulate_base(
        proposal.measurement, config, workers, effects=[part.effect for part in fit.linear]
    )
    columns = []
    for part in fit.linear:
        found = next(each for each in base.candidates if each.name == part.effect)
        if part.label not in found.labels:
            raise FitFailure(f"{part.effect} with {part.label} does not reach all readings")
        columns.append(found.shapes[found.labels.index(part.label)] * part.spread)
    changes = np.column_stack(columns)
    return readings + changes @ fit.zeta[first:], np.hstack([slopes, changes])


def _own_nuisances(
    problem: Problem, proposal: Proposal, config: Config, workers: Workers
) -> dict[str, Vector]:
    """Nuisances of an addition's readings, by name; what fits find is left out."""
    case = Case(neutral_stages(config), keys(proposal.measurement, config), headroom=True)
    (base,) = simulate(proposal.measurement, config, [case], workers)
    return {
        each.name: np.nan_to_num(each.change)
        for each in nuisances(proposal.measurement, base)
        if problem.scale is None or each.name not in (MODULUS, AREA)
    }


def _joined(problem: Problem, new: dict[str, Vector], m: int) -> Matrix:
    """Nuisances of the readings so far and of m more; those of the same name are shared."""
    old = {each.name: each.change for each in problem.linear_nuisances()}
    n = len(problem.value)
    columns = []
    for name in dict.fromkeys([*old, *new]):
        # a plate that is set once more is off by another gap
        shared = not name.startswith("plate_gap")
        if name in old and name in new and shared:
            columns.append(np.concatenate([old[name], new[name]]))
            continue
        if name in old:
            columns.append(np.concatenate([old[name], np.zeros(m)]))
        if name in new:
            columns.append(np.concatenate([np.zeros(n), new[name]]))
    return np.column_stack(columns) if columns else np.zeros((n + m, 0))


def _model_error(measurement: Measurement) -> Vector:
    """Relative error of a simulation at each reading."""
    error = {
        test.number: test.setup.nuisances["material_law"]
        if test.experiment == "coupon"
        else MODEL_ERROR
        for test in measurement.tests
    }
    return np.array([error[number] for number in measurement.listed()["test"]])


def _noise_std(problem: Problem, column: str) -> float:
    same = (problem.index["channel"] == column).to_numpy()
    if same.any():
        return float(np.median(problem.noise_std[same]))
    return CHANNELS[column].noise

"""What a proposed experiment would tell about effects that are tied, per minute.

If effect e is there as fitted, fitting f in its place leaves about ½ Δᵀ C⁻¹ Δ in log likelihood, Δ
the difference of both fits and C the covariance with f's own parameters free: the expected log
Bayes factor. An addition is worth what it adds, over the readings so far and its own together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.laplace import slope
from dolfingrip.diagnosis.inference.next_experiment import ENOUGH
from dolfingrip.diagnosis.inference.noise import DEFAULTS
from dolfingrip.diagnosis.model import FitFailure
from dolfingrip.diagnosis.problem import AREA, MODULUS, Problem
from dolfingrip.diagnosis.simulation import meshes
from dolfingrip.diagnosis.simulation.nuisances import keys, neutral_stages, nuisances
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import Case, simulate

APART: Final = float(np.log(20))
"""Expected log Bayes factor from which on two effects are told apart."""

MODEL_ERROR: Final = 0.01
"""Relative error of a simulation at conditions that nothing was measured at: independent between
readings, so that no tie is split by less than a model can be trusted."""


@dataclass(frozen=True)
class AdditionWorth:
    """An addition, judged.

    Attributes:
        name, minutes: of it.
        gain: expected increase of the log Bayes factor, averaged over pairs of tied effects.
        gain_per_minute: the same up to what decides, by the minute.
        splits: whether all pairs are expected to be told apart with it.
    """

    name: str
    minutes: float
    gain: float
    gain_per_minute: float
    splits: bool


def judge(
    problem: Problem,
    tied: Sequence[tuple[Hypothesis, float]],
    proposals: Sequence[Proposal],
    workers: Workers,
    say: Callable[[str], None],
) -> tuple[list[AdditionWorth], list[str]]:
    """Additions in the order of what they tell per minute, and why some could not be judged.

    Those that are expected to tell all tied effects apart come first.

    Args:
        problem: the readings so far.
        tied: fitted effects that they cannot tell apart, with their probabilities.
        proposals: what could be added.
        workers: where simulations are computed.
        say: told what is being done.
    """
    weights = np.outer(*(2 * [np.array([p for _, p in tied])]))
    np.fill_diagonal(weights, 0.0)
    weights /= max(weights.sum(), 1e-300)
    fits = [fit for fit, _ in tied]
    before = _matrix(problem.covariance, [f.readings for f in fits], [f.jacobian for f in fits])
    found, failed = [], []
    for proposal in proposals:
        say(f"next experiment: {proposal.name}")
        try:
            after = _after(problem, fits, proposal, workers)
        except (FitFailure, ConfigError) as failure:
            failed.append(f"{proposal.name} could not be judged: {failure}")
            continue
        useful = np.minimum(after, ENOUGH) - np.minimum(before, ENOUGH)
        off = ~np.eye(len(fits), dtype=bool)
        found.append(
            AdditionWorth(
                proposal.name,
                proposal.minutes,
                float((weights * (after - before)).sum()),
                float((weights * useful).sum() / proposal.minutes),
                bool((after[off] > APART).all()),
            )
        )
    return sorted(found, key=lambda worth: (not worth.splits, -worth.gain_per_minute)), failed


def _after(
    problem: Problem, fits: Sequence[Hypothesis], proposal: Proposal, workers: Workers
) -> Matrix:
    """Expected log Bayes factors with the addition."""
    base = problem.base
    flat = () if proposal.known_mesh else meshes.ungraded(base.config)
    config = base.config.overridden(flat) if flat else base.config
    measurement = proposal.measurement
    listed = measurement.listed()
    readings, slopes = [], []
    for fit in fits:
        own, jacobian = _readings(fit, proposal, config, workers)
        readings.append(np.concatenate([fit.readings, own]))
        slopes.append(np.vstack([fit.jacobian, jacobian]))
    columns = _nuisances(problem, proposal, config, workers)
    std = np.array([_noise_std(problem, str(column)) for column in listed["column"]])
    std = np.hypot(std, MODEL_ERROR * np.abs(readings[0][len(problem.value) :]))
    n = len(problem.value)
    noise = np.zeros((n + len(std), n + len(std)))
    noise[:n, :n] = problem.error_covariance.matrix
    noise[n:, n:] = np.diag(std**2)
    return _matrix(Covariance.of(noise + columns @ columns.T), readings, slopes)


def _readings(
    fit: Hypothesis, proposal: Proposal, config: Config, workers: Workers
) -> tuple[Vector, Matrix]:
    """Readings of an addition as a fit has them, with derivatives by ζ."""
    if fit.model is None:
        raise FitFailure(f"{' with '.join(fit.effects)} is an instrument's")
    # the gap and the regulator's zero of an addition are others, not those that were fitted
    kept = fit.model.unshifted
    model = replace(
        fit.model, measurement=proposal.measurement, config=config, workers=workers,
        base=None, scales=False, count=0, shifts=(), _known={},
    )  # fmt: skip
    readings, own = model.evaluate([fit.values[i] for i in kept])
    slopes = np.zeros((len(readings), len(fit.parameters)))
    slopes[:, kept] = own
    by_zeta = [slope(p.prior, float(z)) for p, z in zip(fit.parameters, fit.zeta, strict=True)]
    return readings, slopes * np.array(by_zeta)


def _nuisances(problem: Problem, proposal: Proposal, config: Config, workers: Workers) -> Matrix:
    """Nuisances of all readings; those of the same name are shared."""
    case = Case(neutral_stages(config), keys(proposal.measurement, config), headroom=True)
    (base,) = simulate(proposal.measurement, config, [case], workers)
    new = {
        each.name: np.nan_to_num(each.change)
        for each in nuisances(proposal.measurement, base)
        if problem.scale is None or each.name not in (MODULUS, AREA)
    }
    old = {each.name: each.change for each in problem.linear_nuisances()}
    n, m = len(problem.value), len(base.readings)
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


def _noise_std(problem: Problem, column: str) -> float:
    same = (problem.index["channel"] == column).to_numpy()
    if same.any():
        return float(np.median(problem.noise_std[same]))
    return DEFAULTS[column].std


def _matrix(covariance: Covariance, readings: Sequence[Vector], slopes: Sequence[Matrix]) -> Matrix:
    """Expected log Bayes factor if the row's effect is there, against the column's."""
    found = np.zeros((len(readings), len(readings)))
    for j, other in enumerate(readings):
        own = covariance.widened(slopes[j])
        for i, true in enumerate(readings):
            if i != j:
                white = own.whiten(true - other)
                found[i, j] = 0.5 * float(white @ white)
    return found

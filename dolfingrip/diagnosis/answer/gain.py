"""Errors on readings that were left out; causes are chosen anew without them.

What is scored is what ``extended.toml`` delivers: an exact simulation at the numbers that the other
readings tell. Of a specimen that was left out its own scale is fitted, for all models alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.linalg

from dolfingrip.diagnosis.answer.analysed import Analysed
from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import NONE, Posterior, searched_again
from dolfingrip.diagnosis.outcome import Gain
from dolfingrip.diagnosis.policy import POLICY

SPECIMENS = "specimens"
BANDS = "bands of load"
BRANCHES = "branches and cycles"


@dataclass(frozen=True, eq=False)
class Fold:
    """Readings that were left out together.

    Attributes:
        kind: what was left out.
        part: which they are, shape (n,) of bool.
        causes: that were named without them.
        configured, nuisances, process, cause: predictions of all readings, shape (n,).
        log_odds: ln of how much more probable the left-out readings are with the cause than with
            the nuisances refitted, and than with a process without cause.
    """

    kind: str
    part: np.ndarray
    causes: tuple[str, ...]
    configured: np.ndarray
    nuisances: np.ndarray
    process: np.ndarray
    cause: np.ndarray
    log_odds: tuple[float, float]


@dataclass(frozen=True, eq=False)
class HeldOut:
    """All folds.

    Attributes:
        folds: one by one.
        errors: by kind and channel.
        scatter: root mean square distance of the specimens from the others, their scale fitted,
            by channel; empty where there is one.
    """

    folds: tuple[Fold, ...]
    errors: tuple[Gain, ...]
    scatter: dict[str, float]

    @property
    def claimed(self) -> bool:
        """Whether the cause foretells what was left out better than both rivals."""
        if not self.folds:
            return False
        odds = np.array([fold.log_odds for fold in self.folds])
        return bool(odds[:, 0].sum() >= POLICY.foretold and odds[:, 1].sum() > 0)


def held_out(
    analysed: Analysed[Any],
    whole: Posterior,
    told: Callable[[str], None] = lambda text: None,
) -> HeldOut:
    """Leave out each specimen in turn, and bands and branches where there are some."""
    listed = analysed.measurement.listed()
    channel = listed["column"].to_numpy()
    specimen = listed["specimen"].to_numpy()
    folds = []
    parts = list(_parts(analysed))
    for number, (kind, part) in enumerate(parts):
        told(f"left out: {kind}, {number + 1} of {len(parts)}")
        folds.append(_fold(analysed, whole, kind, part))
    errors = []
    for kind in dict.fromkeys(fold.kind for fold in folds):
        for name in dict.fromkeys(channel):
            own = [fold for fold in folds if fold.kind == kind]
            errors.append(_error(own, kind, str(name), channel == name, analysed.case.value))
    return HeldOut(tuple(folds), tuple(errors), _scatter(analysed, channel, specimen))


def _parts(analysed: Analysed[Any]) -> Iterator[tuple[str, np.ndarray]]:
    listed = analysed.measurement.listed()
    specimen = listed["specimen"].to_numpy()
    names = list(dict.fromkeys(specimen))
    if len(names) > 1:
        for name in names:
            yield SPECIMENS, specimen == name
    else:
        edges = np.quantile(analysed.errors.along.load, [0, 1 / 3, 2 / 3, 1])
        for low, high in pairwise(edges):
            part = (analysed.errors.along.load >= low) & (analysed.errors.along.load <= high)
            if 0 < part.sum() < len(part):
                yield BANDS, part
    ways = (listed["cycle"].astype(str) + listed["branch"].astype(str)).to_numpy()
    every = list(dict.fromkeys(ways))
    if len(every) > 1:
        for name in every[1:]:
            yield BRANCHES, ways == name


def _fold(
    analysed: Analysed[Any],
    whole: Posterior,
    kind: str,
    part: np.ndarray,
) -> Fold:
    case = analysed.case
    rest = searched_again(case.rows(~part), whole)
    decision = decide(rest)
    chosen = decision.best
    plain = rest.best(NONE, level=0.0)
    free = rest.best(NONE)
    alone = kind == SPECIMENS

    def conditioned(mean: np.ndarray, level: float) -> np.ndarray:
        total = case.covariance + level**2 * case.kernel
        inner = scipy.linalg.cho_factor(total[np.ix_(~part, ~part)], lower=True)
        left = scipy.linalg.cho_solve(inner, case.value[~part] - mean[~part])
        return np.asarray(mean + total[:, ~part] @ left)

    def scale(prediction: np.ndarray) -> np.ndarray:
        own = part & analysed.scaled
        if not alone or not own.any():
            return prediction
        square = float(prediction[own] @ prediction[own])
        factor = float(prediction[own] @ case.value[own]) / square if square > 0 else 1.0
        return np.where(own, factor, 1.0) * prediction

    cause = analysed.exact(chosen) if decision.answer == "cause" else analysed.exact(plain)
    return Fold(
        kind, part, chosen.subset, scale(case.base),
        scale(conditioned(analysed.exact(plain), 0.0)),
        scale(conditioned(analysed.exact(free), free.level)),
        scale(conditioned(cause, 0.0)), _log_odds(whole, rest),
    )  # fmt: skip


def _log_odds(whole: Posterior, rest: Posterior) -> tuple[float, float]:
    """By the evidence of all readings and of the rest: ln p(left out | rest) of each model."""

    def density(model: Callable[[Fit], bool]) -> float:
        found = []
        for posterior in (whole, rest):
            logs = [
                np.log(p) + posterior.log_density
                for p, fit in zip(posterior.probability, posterior.fits, strict=True)
                if p > 0 and model(fit)
            ]
            if not logs:
                return -1e3
            found.append(float(np.logaddexp.reduce(logs)))
        return found[0] - found[1]

    causes = whole.case.causes
    cause = density(lambda fit: bool(causes(fit.subset)))
    plain = density(lambda fit: not causes(fit.subset) and fit.level == 0)
    process = density(lambda fit: not causes(fit.subset))
    return cause - plain, cause - process


def _error(
    folds: list[Fold], kind: str, channel: str, which: np.ndarray, value: np.ndarray
) -> Gain:
    def rms(of: Callable[[Fold], np.ndarray], chosen: np.ndarray) -> float:
        squares = [((of(folds[i]) - value)[folds[i].part & which]) ** 2 for i in chosen]
        together = np.concatenate(squares)
        return float(np.sqrt(together.mean())) if together.size else 0.0

    every = np.arange(len(folds))
    rng = np.random.default_rng(0)
    drawn = [rng.integers(0, len(folds), len(folds)) for _ in range(200)]
    errors = np.array(
        [(rms(lambda f: f.cause, chosen), rms(lambda f: f.nuisances, chosen)) for chosen in drawn]
    )
    tail = (1 - POLICY.interval) / 2
    ends = np.quantile(errors[:, 0], [tail, 1 - tail])
    ratios = np.quantile(errors[:, 0] / np.maximum(errors[:, 1], 1e-300), [tail, 1 - tail])
    odds = np.sum([fold.log_odds for fold in folds], axis=0)
    return Gain(
        left_out=kind, channel=channel, folds=len(folds), before=rms(lambda f: f.configured, every),
        nuisances=rms(lambda f: f.nuisances, every), process=rms(lambda f: f.process, every),
        cause=rms(lambda f: f.cause, every), cause_low=float(ends[0]), cause_high=float(ends[1]),
        by_nuisances_low=float(ratios[0]), by_nuisances_high=float(ratios[1]),
        log_odds_nuisances=float(odds[0]), log_odds_process=float(odds[1]),
    )  # fmt: skip


def _scatter(
    analysed: Analysed[Any], channel: np.ndarray, specimen: np.ndarray
) -> dict[str, float]:
    """How far each specimen is from a smooth curve through the others, its scale fitted."""
    names = list(dict.fromkeys(specimen))
    if len(names) == 1:
        return {}
    case, along = analysed.case, analysed.errors.along
    listed = analysed.measurement.listed()
    ways = (listed["cycle"].astype(str) + listed["branch"].astype(str)).to_numpy()
    squares: dict[str, list[np.ndarray]] = {}
    for name in names:
        for column in dict.fromkeys(channel):
            for way in dict.fromkeys(ways):
                own = (specimen == name) & (channel == column) & (ways == way)
                rest = (specimen != name) & (channel == column) & (ways == way)
                if own.sum() < 3 or rest.sum() < 3:
                    continue
                degree = int(np.clip(len(np.unique(np.round(along.load[rest], 3))) // 4, 1, 6))
                curve = np.polynomial.Chebyshev.fit(along.load[rest], case.value[rest], degree)
                told = curve(along.load[own])
                if analysed.scaled[own].all():
                    told = told * float(told @ case.value[own]) / float(told @ told)
                squares.setdefault(str(column), []).append((case.value[own] - told) ** 2)
    return {column: float(np.sqrt(np.concatenate(each).mean())) for column, each in squares.items()}

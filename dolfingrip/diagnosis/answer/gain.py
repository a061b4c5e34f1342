"""Errors on readings that were left out; causes are chosen anew without them.

What is scored is what ``extended.toml`` delivers: an exact simulation at the numbers that the other
readings tell. Of a specimen that was left out its own scale is fitted, for all models alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg

from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.problem import NONE, InferenceProblem
from dolfingrip.diagnosis.core.search import ModelPosterior, searched_again
from dolfingrip.diagnosis.data.measurement import in_proportion
from dolfingrip.files.diagnosis import HeldOutError

SPECIMENS = "specimens"
BANDS = "bands of load"
BRANCHES = "branches and cycles"


@dataclass(frozen=True, eq=False)
class Fold:
    """Readings that were left out together.

    Attributes:
        kind: what was left out.
        part: which they are, shape (n,) of bool.
        predictions: of all readings, shape (n,), as configured (``before``), and by the other
            readings with ``nuisances`` refitted, a ``process`` without cause and with the
            ``cause``.
        log_odds: ln of how much more probable the left-out readings are with the cause than with
            the nuisances refitted, and than with a process without cause.
    """

    kind: str
    part: np.ndarray
    predictions: dict[str, np.ndarray]
    log_odds: tuple[float, float]


def held_out(analysis: Analysis, full: ModelPosterior) -> tuple[tuple[HeldOutError, ...], bool]:
    """Leave out each specimen in turn, and bands and branches where there are some.

    Args:
        analysis: readings with all that could explain them.
        full: of all hypotheses by all readings.

    Returns:
        Errors by kind and channel, and whether the cause predicts what was left out better than
        both rivals.
    """
    folds = [_fold(analysis, full, kind, part) for kind, part in _parts(analysis)]
    errors = [
        _error([fold for fold in folds if fold.kind == kind], kind, name, which, analysis.problem)
        for kind in dict.fromkeys(fold.kind for fold in folds)
        for name, which in analysis.measurement.channels().items()
    ]
    by_nuisances = sum(fold.log_odds[0] for fold in folds)
    by_process = sum(fold.log_odds[1] for fold in folds)
    claimed = by_nuisances >= analysis.problem.policy.log_odds and by_process > 0
    return tuple(errors), claimed


def _parts(analysis: Analysis) -> Iterator[tuple[str, np.ndarray]]:
    """Iterate over what is left out in turn: its kind, and which readings, (n,) of bool."""
    listed = analysis.measurement.listed
    specimen = listed["specimen"].to_numpy()
    names = list(dict.fromkeys(specimen))
    if len(names) > 1:
        for name in names:
            yield SPECIMENS, specimen == name
    else:
        load = analysis.errors.along.load
        for low, high in pairwise(
            np.quantile(load, np.linspace(0, 1, analysis.problem.policy.few))
        ):
            part = (load >= low) & (load <= high)
            if 0 < part.sum() < len(part):
                yield BANDS, part
    ways = (listed["cycle"].astype(str) + listed["branch"].astype(str)).to_numpy()
    for way in list(dict.fromkeys(ways))[1:]:
        yield BRANCHES, ways == way


def _fold(analysis: Analysis, full: ModelPosterior, kind: str, part: np.ndarray) -> Fold:
    problem = analysis.problem
    without = searched_again(problem.rows(~part), full)
    decision = decide(without)
    free = without.best(NONE)
    plain = analysis.exact(without.best(NONE, level=0.0))
    cause = analysis.exact(decision.best) if decision.answer == "cause" else plain
    if not np.isfinite(cause).all():  # without equilibrium at some reading nothing is predicted
        cause = plain

    def conditioned(mean: np.ndarray, level: float) -> np.ndarray:
        total = problem.covariance + level**2 * problem.kernel
        inner = scipy.linalg.cho_factor(total[np.ix_(~part, ~part)], lower=True)
        left = scipy.linalg.cho_solve(inner, problem.value[~part] - mean[~part])
        return np.asarray(mean + total[:, ~part] @ left)

    def scale(prediction: np.ndarray) -> np.ndarray:
        mine = part & in_proportion(analysis.measurement)
        if kind != SPECIMENS or not mine.any():
            return prediction
        square = float(prediction[mine] @ prediction[mine])
        factor = float(prediction[mine] @ problem.value[mine]) / square if square > 0 else 1.0
        return np.where(mine, factor, 1.0) * prediction

    means = {
        "before": problem.base, "nuisances": conditioned(plain, 0.0),
        "process": conditioned(analysis.exact(free), free.level), "cause": conditioned(cause, 0.0),
    }  # fmt: skip
    predictions = {name: scale(curve) for name, curve in means.items()}
    return Fold(kind, part, predictions, _log_odds(full, without))


def _log_odds(full: ModelPosterior, without: ModelPosterior) -> tuple[float, float]:
    """By the evidence of all readings and of the rest: ln p(left out | rest) of each model."""

    def models(posterior: ModelPosterior) -> np.ndarray:
        by = posterior.by(lambda fit: (bool(posterior.problem.causes(fit.subset)), fit.level > 0))
        cause = by.get((True, False), 0.0) + by.get((True, True), 0.0)
        plain, beside = by.get((False, False), 0.0), by.get((False, True), 0.0)
        return np.array([cause, plain, plain + beside])

    before, after = models(without), models(full)
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(after / before) + full.log_density - without.log_density
    cause, plain, process = np.where((before > 0) & (after > 0), logs, -1e3)
    return float(cause - plain), float(cause - process)


def _error(
    folds: list[Fold], kind: str, channel: str, which: np.ndarray, problem: InferenceProblem
) -> HeldOutError:
    def rms(by: str, chosen: Iterable[int]) -> float:
        some = [folds[i] for i in chosen]
        off = [(fold.predictions[by] - problem.value)[fold.part & which] for fold in some]
        together = np.concatenate(off) ** 2
        return float(np.sqrt(together.mean())) if together.size else 0.0

    rng, policy = np.random.default_rng(0), problem.policy
    drawn = [rng.integers(0, len(folds), len(folds)) for _ in range(policy.draws // 2)]
    errors = [rms("cause", chosen) for chosen in drawn]
    tail = (1 - policy.nearly) / 2
    ends = np.quantile(errors, [tail, 1 - tail])
    odds = np.sum([fold.log_odds for fold in folds], axis=0)
    return HeldOutError(
        left_out=kind, channel=channel, folds=len(folds),
        **{name: rms(name, range(len(folds))) for name in folds[0].predictions},
        cause_low=float(ends[0]), cause_high=float(ends[1]),
        log_odds_nuisances=float(odds[0]), log_odds_process=float(odds[1]),
    )  # fmt: skip

"""Errors before and after on what was left out, and its odds, against two rivals.

Each fold is refitted with the derivatives at the full fit, so no new simulation is made. The rivals
are the base model with its nuisances refitted, and that with a Gaussian process for the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.diagnosis.gain.folds import folds
from dolfingrip.diagnosis.gain.odds import Fold, Odds, odds_of
from dolfingrip.diagnosis.gain.refitted import Refitted
from dolfingrip.diagnosis.gain.rivals import NuisanceFit, with_process
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit
from dolfingrip.diagnosis.problem import Problem

DRAWS: Final = 1000
SEED: Final = 0
OWN_SCALE: Final = "specimens, their scale fitted"
"""Coupons that are left out but for one number, their scale: what is left is the law's alone."""


@dataclass(frozen=True)
class GainRow:
    """Root mean square errors of one channel, in its unit, over all folds of a kind."""

    left_out: str
    channel: str
    folds: int
    before: float
    nuisances: float
    process: float
    cause: float
    cause_interval: tuple[float, float]
    by_nuisances: tuple[float, float]


def gains(
    problem: Problem, none: Hypothesis, cause: Hypothesis
) -> tuple[list[GainRow], list[Odds]]:
    """A row of errors for each kind of fold and channel, and the odds of what was left out."""
    smooth = SmoothMisfit(problem.index, none.covariance(problem), problem.noise_std)
    nuisances = NuisanceFit(problem, none)
    rows: list[GainRow] = []
    odds: list[Odds] = []
    coupons = bool((problem.index["experiment"] == "coupon").all())
    for kind, parts in folds(problem.index).items():
        every = [
            Fold(part, nuisances.refitted(~part), with_process(problem, none, smooth, ~part),
                  Refitted.of(problem, cause, ~part))
            for part in parts
        ]  # fmt: skip
        odds.append(odds_of(kind, None, every, np.ones(len(problem.value), dtype=bool)))
        for name in dict.fromkeys(problem.index["channel"]):
            channel = str(name)
            of_channel = (problem.index["channel"] == name).to_numpy()
            felt = [fold for fold in every if (fold.part & of_channel).any()]
            own = [(fold.part & of_channel, *fold.predictions) for fold in felt]
            if felt:
                odds.append(odds_of(kind, channel, felt, of_channel))
            if len(own) > 1:
                rows.append(_row(kind, channel, problem, own))
            if len(own) > 1 and coupons and kind == "specimens":
                scaled = [(part, *(_scaled(problem, part, p) for p in rest)) for part, *rest in own]
                rows.append(_row(OWN_SCALE, channel, problem, scaled))
    return rows, odds


def _scaled(problem: Problem, part: np.ndarray, predicted: Vector) -> Vector:
    """With the scale that fits a part best, as of a cross-section that is not known."""
    own = predicted[part]
    return np.asarray(predicted * (float(own @ problem.value[part]) / float(own @ own)))


def _row(
    kind: str,
    channel: str,
    problem: Problem,
    parts: Sequence[tuple[np.ndarray, Vector, Vector, Vector]],
) -> GainRow:
    squares = np.array(
        [
            [
                float(np.sum((problem.value - predicted)[part] ** 2))
                for predicted in (problem.simulated, *rest)
            ]
            for part, *rest in parts
        ]
    )
    counts = np.array([part.sum() for part, *_ in parts], dtype=float)
    errors = np.sqrt(squares.sum(axis=0) / counts.sum())
    draws = np.random.default_rng(SEED).integers(len(parts), size=(DRAWS, len(parts)))
    drawn = np.sqrt(squares[draws].sum(axis=1) / counts[draws].sum(axis=1)[:, None])
    interval = np.quantile(drawn[:, 3], (0.05, 0.95))
    ratio = np.quantile(drawn[:, 3] / np.maximum(drawn[:, 1], 1e-300), (0.05, 0.95))
    before, nuisances, process, cause = (float(error) for error in errors)
    return GainRow(
        kind, channel, len(parts), before, nuisances, process, cause,
        (float(interval[0]), float(interval[1])), (float(ratio[0]), float(ratio[1])),
    )  # fmt: skip

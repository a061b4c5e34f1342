"""Errors before and after on what was left out, against two rivals.

Each fold is refitted with the derivatives at the full fit, so no new simulation is made. The rivals
are the base model with its nuisances refitted, and that with a Gaussian process for the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.diagnosis.gain.folds import folds
from dolfingrip.diagnosis.gain.rivals import NuisanceFit, with_process
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit
from dolfingrip.diagnosis.problem import Problem

DRAWS: Final = 1000
SEED: Final = 0
OWN_SCALE: Final = "specimens, their scale fitted"
"""Coupons that are left out but for one number, their scale: what is left is the law's alone."""

EQUAL: Final = 1.1
"""A cause that is no worse than this by a rival's error is as good."""


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


def gains(problem: Problem, none: Hypothesis, cause: Hypothesis) -> list[GainRow]:
    """A row for each kind of fold and channel."""
    smooth = SmoothMisfit(problem.index, none.covariance(problem), problem.noise_std)
    nuisances = NuisanceFit(problem, none)
    found: list[GainRow] = []
    coupons = bool((problem.index["experiment"] == "coupon").all())
    for kind, parts in folds(problem.index).items():
        predictions = [
            (part, nuisances.refitted(~part), with_process(problem, none, smooth, ~part),
             cause.predicted(problem, ~part))
            for part in parts
        ]  # fmt: skip
        for channel in dict.fromkeys(problem.index["channel"]):
            of_channel = (problem.index["channel"] == channel).to_numpy()
            own = [(part & of_channel, *rest) for part, *rest in predictions]
            own = [entry for entry in own if entry[0].any()]
            if len(own) > 1:
                found.append(_row(kind, str(channel), problem, own))
            if len(own) > 1 and coupons and kind == "specimens":
                scaled = [(part, *(_scaled(problem, part, p) for p in rest)) for part, *rest in own]
                found.append(_row(OWN_SCALE, str(channel), problem, scaled))
    return found


def _scaled(problem: Problem, part: np.ndarray, predicted: Vector) -> Vector:
    """With the scale that fits a part best, as of a cross-section that is not known."""
    own = predicted[part]
    return np.asarray(predicted * (float(own @ problem.value[part]) / float(own @ own)))


def claimed(rows: Sequence[GainRow]) -> bool:
    """Whether a cause beats both rivals.

    It has to be better than refitted nuisances in sum, with certainty somewhere and never certainly
    worse, and better than the process somewhere and as good in sum: a process that has seen the
    same place of another specimen repeats it as well as any cause.
    """
    rows = [row for row in rows if row.left_out != OWN_SCALE]
    if not rows:
        return False
    nuisances = np.array([row.cause / row.nuisances for row in rows])
    process = np.array([row.cause / row.process for row in rows])
    certain = any(row.by_nuisances[1] < 1 for row in rows)
    worse = any(row.by_nuisances[0] > 1 for row in rows)
    return bool(
        certain
        and not worse
        and np.exp(np.log(nuisances).mean()) < 1
        and process.min() < 1
        and np.exp(np.log(process).mean()) < EQUAL
    )


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

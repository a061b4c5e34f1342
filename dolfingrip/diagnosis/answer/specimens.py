"""Differences between specimens: their scatter, and which of them stand apart from the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
import scipy.linalg
from numpy.polynomial import chebyshev
from scipy.special import logsumexp

from dolfingrip.channels import TRANSVERSE_STRAIN
from dolfingrip.diagnosis.answer.discrepancy import Along, kernel
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.diagnosis import Scatter


def between(
    measurement: Measurement, covariance: np.ndarray, along: Along, signal: np.ndarray
) -> tuple[Scatter, np.ndarray, np.ndarray]:
    """Estimate how specimens differ: in stiffness, and by smooth deviations of their own.

    Of several specimens their differences tell both: a curve that all have in common is taken out
    first (restricted likelihood; Patterson & Thompson, Biometrika 58, 1971), so that no hypothesis
    about it matters. The stiffness' size is the most probable. The shape's variance is the expected
    one: of few specimens the most probable is often 0, and what two have in common by chance would
    be taken for a cause. Beside fingers, and of one specimen, the shape of coupons is assumed: no
    simple law follows them exactly.

    Returns:
        Their scatter, and covariances by the stiffness and the shape of each, shape (n, n).
    """
    individual = Individual(measurement, covariance, along, signal)
    prior_scale = individual.told
    one_curve = len({test.experiment for test in measurement.tests}) == 1
    specimens = len(set(individual.specimen))
    if specimens == 1 or not one_curve:
        coupon = (measurement.listed["experiment"] == "coupon").to_numpy()
        shape = kernel(along) * np.outer(coupon, coupon)
        least, *_ = individual.policy.discrepancy_levels
        level = least if coupon.all() else 0.0
        scatter = Scatter(
            specimens=specimens, scale=0.0, prior_scale=prior_scale, shape=level, estimated=False
        )
        return scatter, np.zeros_like(shape), least**2 * shape
    likelihood = individual.likelihood()
    best = 0
    for number, of in enumerate(likelihood.max(axis=1)):
        if of > likelihood[best].max() + 0.5:
            best = number
    scale = individual.scales[best] * prior_scale
    weights = np.exp(likelihood[best] - likelihood[best].max())
    levels = np.array(individual.policy.specimen_shapes)
    level = float(np.sqrt(weights @ levels**2 / weights.sum()))
    scatter = Scatter(
        specimens=specimens, scale=scale, prior_scale=prior_scale, shape=level, estimated=True,
        wide=scale > 2 * prior_scale,
    )  # fmt: skip
    return scatter, individual.apart(scale, 0.0), individual.apart(0.0, level)


@dataclass(eq=False)
class Individual:
    """Readings of specimens that share a curve, each with a stiffness and a shape of its own.

    Attributes:
        measurement: the readings.
        covariance: of everything else, shape (n, n).
        along: where they lie.
        signal: a smooth curve through them, shape (n,).
        some: which of the readings; all where None.
    """

    measurement: Measurement
    covariance: np.ndarray
    along: Along
    signal: np.ndarray
    some: np.ndarray | None = None

    def __post_init__(self) -> None:
        listed = self.measurement.listed
        at = np.arange(len(listed)) if self.some is None else self.some
        self._listed = listed.iloc[at].reset_index(drop=True)
        self.covariance = self.covariance[np.ix_(at, at)]
        self.along = self.along.at(at)
        self.specimen = self._listed["specimen"].to_numpy()
        scaled = (self._listed["column"] != TRANSVERSE_STRAIN.name).to_numpy() * self.signal[at]
        self._stiff, self._shape = np.outer(scaled, scaled), kernel(self.along)
        self._same = self.specimen[:, None] == self.specimen

    @property
    def policy(self) -> Policy:
        """Numbers that they are compared by."""
        return self.measurement.policy

    @property
    def scales(self) -> list[float]:
        """Factors of the scatter of their stiffness that are compared."""
        return [1.0, *(width for width in self.policy.widths if width > 1)]

    @property
    def told(self) -> float:
        """Relative scatter of the stiffness as the laboratory told it."""
        tests = self.measurement.tests
        return float(np.max([test.setup.nuisances["specimen_scale"] for test in tests]))

    def apart(self, scale: float, shape: float) -> np.ndarray:
        """Covariance (n, n) by the specimens' own stiffness and shape, relative."""
        return (scale**2 * self._stiff + shape**2 * self._shape) * self._same

    def likelihood(self, outside: Sequence[str] = ()) -> np.ndarray:
        """ln of the restricted likelihood of each scatter of stiffness (rows) and shape.

        Args:
            outside: specimens that stand apart from the others.
        """
        common, value = _common(self._listed, self.along), self._listed["value"].to_numpy()
        far = np.isin(self.specimen, outside)
        wide = 0.01 * (self._stiff + self._shape) * self._same * np.outer(far, far)
        return np.array([
            [
                _restricted(
                    self.covariance + wide + self.apart(factor * self.told, level), common, value
                )
                for level in self.policy.specimen_shapes
            ]
            for factor in self.scales
        ])  # fmt: skip

    def evidence(self, outside: Sequence[str]) -> float:
        """ln p of the readings where some specimens stand apart, the scatter integrated out."""
        logs = self.likelihood(outside)
        return float(np.logaddexp.reduce(logs, axis=None) - np.log(logs.size))


def _common(listed: pd.DataFrame, along: Along) -> np.ndarray:
    """Columns of any curve that all specimens share, (n, k).

    It has as many numbers as one specimen has readings: what it cannot follow would be taken for
    scatter, and hide what the model misses of all specimens alike.
    """
    columns: list[np.ndarray] = []
    for at in along.ways(listed):
        x = along.load[at]
        count = int(listed.iloc[at].groupby("test").size().median())
        places = len(np.unique(np.round(x / along.policy.gauge)))
        degree = min(places, count, along.policy.most_stops - 1) - 1
        shapes = np.zeros((len(along.load), degree + 1))
        span = max(float(np.ptp(x)), 1e-9)
        shapes[at] = chebyshev.chebvander(2 * (x - x.min()) / span - 1, degree)
        columns.append(shapes)
    return np.hstack(columns)


def _restricted(covariance: np.ndarray, common: np.ndarray, value: np.ndarray) -> float:
    lower = scipy.linalg.cholesky(covariance, lower=True)
    white = scipy.linalg.solve_triangular(lower, np.column_stack([value, common]), lower=True)
    q, r = np.linalg.qr(white[:, 1:])
    residual = white[:, 0] - q @ (q.T @ white[:, 0])
    determinant = np.log(np.diag(lower)).sum() + np.log(np.abs(np.diag(r)) + 1e-300).sum()
    return float(-0.5 * residual @ residual - determinant)


def apart(readings: Individual) -> tuple[tuple[str, ...], float] | None:
    """Find the specimens whose readings are far likelier apart from those of the others.

    A specimen that stands apart has a curve of its own, up to a tenth of the signal away from the
    others'. The curve that the others share is taken out first, so that no hypothesis about it
    matters (restricted likelihood, as where their scatter is estimated).

    Args:
        readings: those of specimens, of which two may stand apart where there are four.

    Returns:
        Their names, and ln of the odds that they stand apart, and no others; None where none does,
        or where too few specimens could tell.
    """
    names = sorted(set(readings.specimen))
    # two at least share a curve; which two, four specimens tell where the others differ
    log = {
        outside: readings.evidence(outside) + len(outside) * float(np.log(readings.policy.rare))
        for count in range(min(2, len(names) - 2) + 1)
        for outside in combinations(names, count)
    }
    best = max(log, key=log.__getitem__)
    others = [value for outside, value in log.items() if outside != best]
    log_odds = log[best] - float(logsumexp(others)) if others else 0.0
    return (best, log_odds) if best and log_odds > readings.policy.log_odds else None

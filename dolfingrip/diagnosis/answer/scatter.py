"""How specimens differ from one another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy.linalg

from dolfingrip.channels import TRANSVERSE_STRAIN
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.discrepancy import Along
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import POLICY


@dataclass(frozen=True, eq=False)
class Scatter:
    """How far the specimens differ from one another.

    Attributes:
        scale: relative standard deviation of their stiffness.
        told_scale: as the laboratory told, or usual.
        shape: individual deviation, by the root mean square of a channel.
        estimated: whether the readings of several specimens tell these.
    """

    scale: float
    told_scale: float
    shape: float
    estimated: bool


def between(
    measurement: Measurement, covariance: np.ndarray, along: Along, signal: np.ndarray
) -> tuple[Scatter, np.ndarray]:
    """What one specimen differs from another by: its stiffness, and its own smooth deviation.

    Of several specimens their differences tell both: a curve that all have in common is taken out
    first (restricted likelihood; Patterson & Thompson, Biometrika 58, 1971), so that no hypothesis
    about it matters. The stiffness' size is the most probable. The shape's variance is the expected
    one: of few specimens the most probable is often 0, and what two have in common by chance would
    be taken for a cause. Beside fingers, and of one specimen, the shape of coupons is assumed: no
    simple law follows them exactly.
    """
    listed = measurement.listed()
    specimen = listed["specimen"].to_numpy()
    names = sorted(set(specimen))
    scaled = (listed["column"] != TRANSVERSE_STRAIN.name).to_numpy()
    same = specimen[:, None] == specimen
    stiff = np.outer(signal * scaled, signal * scaled) * same
    shape = discrepancy.kernel(along) * same
    told = float(np.max([test.setup.nuisances["specimen_scale"] for test in measurement.tests]))
    if len(names) == 1 or len({test.experiment for test in measurement.tests}) > 1:
        coupon = (listed["experiment"] == "coupon").to_numpy()
        shape = discrepancy.kernel(along) * np.outer(coupon, coupon)
        level = POLICY.single_shape if coupon.all() else 0.0
        return Scatter(0.0, told, level, estimated=False), POLICY.single_shape**2 * shape
    common = _common(listed, along)
    levels = np.array(POLICY.specimen_shapes)
    likelihood = np.array([
        [
            _restricted(
                covariance + (factor * told) ** 2 * stiff + level**2 * shape, common,
                listed["value"].to_numpy(),
            )
            for level in levels
        ]
        for factor in POLICY.specimen_scales
    ])  # fmt: skip
    best = 0
    for number, of in enumerate(likelihood.max(axis=1)):
        if of > likelihood[best].max() + 0.5:
            best = number
    scale = POLICY.specimen_scales[best] * told
    weights = np.exp(likelihood[best] - likelihood[best].max())
    level = float(np.sqrt(weights @ levels**2 / weights.sum()))
    return (
        Scatter(scale, told, level, estimated=True), scale**2 * stiff + level**2 * shape,
    )  # fmt: skip


def _common(listed: pd.DataFrame, along: Along) -> np.ndarray:
    """Columns of any curve that all specimens share, (n, k).

    It has as many numbers as one specimen has readings: what it cannot follow would be taken for
    scatter, and hide what the model misses of all specimens alike.
    """
    columns: list[np.ndarray] = []
    parts = listed.assign(block=along.block).groupby(["block", "cycle", "branch"], sort=False)
    for _, part in parts:
        at = part.index.to_numpy()
        x = along.load[at]
        each = int(part.groupby("test").size().median())
        degree = min(len(np.unique(np.round(x, 3))), each, POLICY.common) - 1
        own = np.zeros((len(along.load), degree + 1))
        span = max(float(np.ptp(x)), 1e-9)
        own[at] = np.polynomial.chebyshev.chebvander(2 * (x - x.min()) / span - 1, degree)
        columns.append(own)
    return np.hstack(columns)


def _restricted(covariance: np.ndarray, common: np.ndarray, value: np.ndarray) -> float:
    lower = scipy.linalg.cholesky(covariance, lower=True)
    white = scipy.linalg.solve_triangular(lower, np.column_stack([value, common]), lower=True)
    q, r = np.linalg.qr(white[:, 1:])
    rest = white[:, 0] - q @ (q.T @ white[:, 0])
    determinant = np.log(np.diag(lower)).sum() + np.log(np.abs(np.diag(r)) + 1e-300).sum()
    return float(-0.5 * rest @ rest - determinant)

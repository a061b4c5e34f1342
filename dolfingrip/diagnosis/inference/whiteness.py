"""Whether what is left of the residual is the noise that was assumed.

With readings in the order of time, L⁻¹r are the innovations: each reading less what those before it
let expect, by its standard deviation. If the covariance is right they are independent and of
variance 1. Their sum of squares tells the size of the noise (χ²), their correlation along a run
whether it is independent (that of neighbours, and Ljung and Box 1978, Biometrika 65:297).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.linalg import cholesky, solve_triangular
from scipy.stats import chi2, norm

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.multiple import holm
from dolfingrip.diagnosis.inference.readings import tracks

LAGS = 5
LEVEL = 0.05
FEWEST = 6
"""Readings below which a channel is not tested by itself, and pairs below which a lag is not."""


@dataclass(frozen=True)
class NoiseTest:
    """One test.

    Attributes:
        name: ``size``, ``neighbours`` or ``lags``.
        channel: that it is about; "" for all together.
        value: size of what is left by the noise assumed, or correlation of neighbours, or Q.
        p: probability of as much by chance.
        p_corrected: the same, corrected for all tests (Holm).
    """

    name: str
    channel: str
    value: float
    p: float
    p_corrected: float


@dataclass(frozen=True)
class NoiseCheck:
    """All tests of one residual.

    Attributes:
        tests: size of the noise by channel and in all, correlation along runs.
        innovations: shape (n,), in the order of the readings.
    """

    tests: tuple[NoiseTest, ...]
    innovations: Vector

    @property
    def failed(self) -> tuple[NoiseTest, ...]:
        """Tests that contradict the noise assumed."""
        return tuple(test for test in self.tests if test.p_corrected < LEVEL)

    @property
    def too_small(self) -> bool:
        """Whether the noise was believed too small."""
        return any(test.name == "size" and test.value > 1 for test in self.failed)

    @property
    def correlated(self) -> bool:
        """Whether readings of a run are left over alike, though noise was believed otherwise."""
        return any(test.name != "size" for test in self.failed)

    def notes(self) -> list[str]:
        """What the tests found, a sentence each; empty where all is as assumed."""
        return [_sentence(test) for test in self.failed]


def check_noise(index: pd.DataFrame, residual: Vector, covariance: Covariance) -> NoiseCheck:
    """Test what is left of a residual.

    Args:
        index: table of the n readings.
        residual: measured − simulated, shape (n,).
        covariance: with all that explains the residual in it.
    """
    runs = tracks(index)
    order = np.concatenate(runs)
    factor = cholesky(covariance.matrix[np.ix_(order, order)], lower=True)
    innovations = np.empty(len(residual))
    innovations[order] = solve_triangular(factor, residual[order], lower=True)
    channels = index["channel"].to_numpy()
    found = [_size("", innovations)]
    names = list(dict.fromkeys(channels))
    scaled = innovations.copy()
    for name in names:
        chosen = channels == name
        size = _size(str(name), innovations[chosen])
        scaled[chosen] /= max(size[2], 1e-12)
        if len(names) > 1 and chosen.sum() >= FEWEST:
            found.append(size)
    found += _along(scaled, runs)
    corrected = holm([p for *_, p in found])
    tests = tuple(NoiseTest(*entry, float(p)) for entry, p in zip(found, corrected, strict=True))
    return NoiseCheck(tests, innovations)


Found = tuple[str, str, float, float]


def _size(channel: str, innovations: Vector) -> Found:
    total, count = float(innovations @ innovations), len(innovations)
    p = 2 * min(chi2.sf(total, count), chi2.cdf(total, count))
    return "size", channel, float(np.sqrt(total / count)), float(min(p, 1.0))


def _along(scaled: Vector, runs: list[npt.NDArray[np.intp]]) -> list[Found]:
    """Correlation of innovations of variance 1 along runs."""
    z, first = [], 0.0
    for lag in range(1, LAGS + 1):
        products = np.concatenate([scaled[run[lag:]] * scaled[run[:-lag]] for run in runs])
        if len(products) < FEWEST:
            break
        z.append(float(products.sum() / np.sqrt(len(products))))
        if lag == 1:
            first = float(products.mean())
    if not z:
        return []
    # noise that drifts leaves neighbours alike, never opposite
    found: list[Found] = [("neighbours", "", first, float(norm.sf(z[0])))]
    total = float(np.sum(np.square(z)))
    return [*found, ("lags", "", total, float(chi2.sf(total, len(z))))]


def _sentence(test: NoiseTest) -> str:
    chance = f"(p = {test.p_corrected:.2g}, corrected for all looks)"
    where = f" in {test.channel}" if test.channel else ""
    if test.name == "size":
        return f"what is left{where} is {test.value:.2g} times the noise that was assumed {chance}"
    if test.name == "neighbours":
        return (
            f"neighbouring readings of a run are left over alike, correlation {test.value:.2f} "
            f"{chance}: noise drifts along runs, or a smooth effect is missing"
        )
    return (
        f"what is left is correlated along runs {chance}: noise is not independent, "
        "or an effect is missing"
    )

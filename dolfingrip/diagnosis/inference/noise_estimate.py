"""The noise as repeats show it: restricted maximum likelihood (REML).

Readings that repeat one another differ by noise, and by the scatter of specimens. With an expected
value for each place of the protocol, and a scale for each specimen, as fixed effects X, the
hyperparameters θ of the noise maximise (Patterson and Thompson 1971, Biometrika 58:545)

    ln L(θ) = −½ ln |Σ| − ½ ln |XᵀΣ⁻¹X| − ½ min_b (y − X b)ᵀ Σ⁻¹ (y − X b).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.linalg import cho_factor, cholesky, qr, solve_triangular
from scipy.optimize import minimize
from scipy.stats import chi2

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.noise import Along, ChannelNoise
from dolfingrip.diagnosis.inference.readings import tracks

FEWEST = 10
"""Degrees of freedom that repeats must leave for an estimate."""
SIGNIFICANT = 0.05
"""Level at which independent noise is rejected for correlated."""


@dataclass(frozen=True)
class FromRepeats:
    """Noise of one channel from its repeats.

    Attributes:
        noise: estimate.
        freedom: degrees of freedom that repeats leave.
        correlation_p: probability of as much correlation along runs by chance.
    """

    noise: ChannelNoise
    freedom: int
    correlation_p: float


def from_repeats(
    index: pd.DataFrame, value: Vector, place: npt.NDArray[np.intp], along: Along = "time_s"
) -> FromRepeats | None:
    """Noise of one channel from its repeats; None where they are too few.

    Args:
        index: table of the channel's readings, n rows.
        value: shape (n,).
        place: number that repeats share, shape (n,).
        along: whether correlation is looked for in time or from reading to reading.
    """
    repeated = np.bincount(place)[place] > 1
    if not repeated.any():
        return None
    index, value, place = index[repeated], value[repeated], place[repeated]
    fixed = fixed_effects(index, value, place)
    freedom = len(value) - fixed.shape[1]
    if freedom < FEWEST:
        return None
    runs = tracks(index)
    positions = [
        index["time_s"].to_numpy(dtype=float)[rows]
        if along == "time_s"
        else np.arange(len(rows), dtype=float)
        for rows in runs
    ]
    problem = Reml(value, fixed, runs, positions)
    scale = problem.independent_std()
    alone = problem.log_likelihood(scale, 0.0, 1.0)
    best, log_likelihood = problem.maximise(scale)
    # twice the gain is between χ² of one and of two degrees of freedom: two errs on the safe side
    p = float(chi2.sf(max(2 * (log_likelihood - alone), 0.0), 2))
    if p >= SIGNIFICANT:
        return FromRepeats(ChannelNoise(scale), freedom, p)
    std, correlated, length = best
    return FromRepeats(ChannelNoise(std, correlated, length, along), freedom, p)


class Reml:
    """The restricted likelihood of one channel, with noise that is independent between runs."""

    def __init__(
        self,
        value: Vector,
        fixed: Matrix,
        runs: list[npt.NDArray[np.intp]],
        positions: list[Vector],
    ) -> None:
        self._both = np.column_stack([fixed, value])
        self._runs = runs
        self._apart = [np.abs(at[:, None] - at[None, :]) for at in positions]
        steps = np.concatenate([np.diff(at) for at in positions])
        steps = steps[steps > 0]
        extent = float(np.max([at[-1] - at[0] for at in positions]))
        self.shortest = float(np.median(steps)) if len(steps) else 1.0
        self.longest = max(3 * extent, 3 * self.shortest)

    def independent_std(self) -> float:
        """The estimate where all noise is independent: the closed form."""
        fixed, value = self._both[:, :-1], self._both[:, -1]
        left = value - fixed @ np.linalg.lstsq(fixed, value, rcond=None)[0]
        variance = float(left @ left) / (len(value) - fixed.shape[1])
        return max(variance, 1e-24) ** 0.5

    def log_likelihood(self, std: float, correlated: float, length: float) -> float:
        white, logdet = np.empty_like(self._both), 0.0
        for rows, apart in zip(self._runs, self._apart, strict=True):
            matrix = correlated**2 * np.exp(-apart / length)
            matrix[np.diag_indices(len(rows))] += std**2
            factor = cholesky(matrix, lower=True, check_finite=False)
            white[rows] = solve_triangular(factor, self._both[rows], lower=True, check_finite=False)
            logdet += 2 * float(np.log(np.diag(factor)).sum())
        fixed, value = white[:, :-1], white[:, -1]
        factor = cho_factor(fixed.T @ fixed, lower=True)[0]
        along = solve_triangular(factor, fixed.T @ value, lower=True)
        left = float(value @ value - along @ along)
        return -0.5 * (logdet + 2 * float(np.log(np.diag(factor)).sum()) + left)

    def maximise(self, scale: float) -> tuple[tuple[float, float, float], float]:
        """Standard deviations of both parts and the length; and the likelihood."""
        bounds = [
            (np.log(scale * 1e-2), np.log(scale * 3)),
            (np.log(scale * 1e-2), np.log(scale * 10)),
            (np.log(self.shortest), np.log(self.longest)),
        ]
        starts = [
            np.log([0.5 * scale, scale, length])
            for length in np.geomspace(1.5 * self.shortest, 0.6 * self.longest, 3)
        ]
        results = [
            minimize(
                lambda theta: -self.log_likelihood(*np.exp(theta)),
                np.clip(start, [low for low, _ in bounds], [high for _, high in bounds]),
                method="L-BFGS-B",
                bounds=bounds,
            )
            for start in starts
        ]
        best = min(results, key=lambda result: float(result.fun))
        std, correlated, length = (float(x) for x in np.exp(best.x))
        return (std, correlated, length), -float(best.fun)


def fixed_effects(index: pd.DataFrame, value: Vector, place: npt.NDArray[np.intp]) -> Matrix:
    """An indicator of each place, and a scale of each specimen; linearly independent columns."""
    labels, where = np.unique(place, return_inverse=True)
    indicator = np.zeros((len(value), len(labels)))
    indicator[np.arange(len(value)), where] = 1.0
    mean = (indicator.T @ value / indicator.sum(axis=0))[where]
    specimen = index["specimen"].to_numpy()
    scales = [mean * (specimen == name) for name in dict.fromkeys(specimen)]
    columns = np.column_stack([indicator, *scales])
    size = np.linalg.norm(columns, axis=0)
    columns = columns[:, size > 0] / size[size > 0]
    _, upper, order = qr(columns, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(upper))
    rank = int((diagonal > 1e-9 * diagonal[0]).sum())
    return np.asarray(columns[:, np.sort(order[:rank])])

"""A Gaussian process that learns from values and gradients, and tells how unsure it is."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

Floats = npt.NDArray[np.float64]

NUGGET = 1e-8
"""Part of the variance that is added to the diagonal: solutions are converged, not noisy."""

LENGTHS = (0.1, 3.0)
"""Shortest and longest correlation length, in ranges of the inputs."""


class GradientProcess:
    """A Gaussian process with squared-exponential covariance over scaled inputs.

    Derivatives of a Gaussian process are jointly Gaussian with it, so gradients are observations
    like values (Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006, section 9.4).
    The lengths are those of greatest likelihood.

    Args:
        inputs: shape (n, d), each about 0 to 1.
        values: shape (n,).
        slopes: shape (n, d); None: values alone.

    Attributes:
        lengths: correlation length along each input.
    """

    def __init__(self, inputs: Floats, values: Floats, slopes: Floats | None = None) -> None:
        self._x, self._mean = np.asarray(inputs, dtype=float), float(np.mean(values))
        observed = np.asarray(values, dtype=float) - self._mean
        self._with_slopes = slopes is not None
        if slopes is not None:
            observed = np.concatenate([observed, np.asarray(slopes, dtype=float).T.ravel()])
        self._y = observed
        dimensions = self._x.shape[1]
        bounds = [tuple(np.log(LENGTHS))] * dimensions
        begin = np.zeros(dimensions)
        found = minimize(self._unlikely, begin, method="L-BFGS-B", bounds=bounds)
        self.lengths: Floats = np.exp(found.x)
        self._factor, self._weights, self._variance = self._solved(self.lengths)

    def predict(self, inputs: Floats) -> tuple[Floats, Floats]:
        """Mean and standard deviation at inputs (m, d), each of shape (m,)."""
        cross = self._covariance(inputs, self._x, self.lengths)[: len(inputs)]
        mean = self._mean + cross @ self._weights
        explained = np.einsum("ij,ji->i", cross, cho_solve(self._factor, cross.T))
        return mean, np.sqrt(self._variance * np.clip(1 - explained, 0.0, None))

    def _solved(self, lengths: Floats) -> tuple[tuple[Floats, bool], Floats, float]:
        covariance = self._covariance(self._x, self._x, lengths)
        covariance[np.diag_indices_from(covariance)] *= 1 + NUGGET
        factor = cho_factor(covariance, lower=True)
        weights = cho_solve(factor, self._y)
        return factor, weights, max(float(self._y @ weights) / len(self._y), 1e-300)

    def _unlikely(self, logarithms: Floats) -> float:
        """Negative logarithm of the likelihood, but for constants, at the best variance."""
        try:
            factor, _, variance = self._solved(np.exp(logarithms))
        except np.linalg.LinAlgError:
            return 1e12
        spread = 2 * np.log(np.diag(factor[0])).sum()
        return float(len(self._y) * np.log(variance) + spread)

    def _covariance(self, a: Floats, b: Floats, lengths: Floats) -> Floats:
        """Covariance of values, then slopes, at a and at b, for a variance of 1."""
        apart = (a[:, None] - b[None]) / lengths**2
        value = np.exp(-0.5 * np.einsum("ijk,ijk->ij", apart, a[:, None] - b[None]))
        if not self._with_slopes:
            return np.asarray(value)
        d = len(lengths)
        blocks = [[value, *(value * apart[:, :, j] for j in range(d))]]
        for i in range(d):
            row = [-value * apart[:, :, i]]
            for j in range(d):
                own = 1 / lengths[i] ** 2 if i == j else 0.0
                row.append(value * (own - apart[:, :, i] * apart[:, :, j]))
            blocks.append(row)
        return np.block(blocks)

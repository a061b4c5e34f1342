"""Columns under a covariance: residuals whitened, and what numbers take over of a change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg


@dataclass(frozen=True, eq=False)
class CovarianceModel:
    """Columns under a covariance C = L Lᵀ.

    Attributes:
        covariance: of readings, and below them of numbers that were read by themselves, (n, n).
        columns: Z, shape (n, k).
    """

    covariance: np.ndarray
    columns: np.ndarray

    @cached_property
    def _lower(self) -> np.ndarray:
        """L, shape (n, n)."""
        return np.asarray(scipy.linalg.cholesky(self.covariance, lower=True))

    @property
    def log_det(self) -> float:
        """ln|C| + n ln 2π."""
        log_2_pi = len(self._lower) * float(np.log(2 * np.pi))
        return 2 * float(np.log(np.diag(self._lower)).sum()) + log_2_pi

    @cached_property
    def gram(self) -> np.ndarray:
        """G = Zᵀ C⁻¹ Z, with one more row and column of zeros, shape (k + 1, k + 1)."""
        white = np.pad(self.whitened(self.columns), ((0, 0), (0, 1)))
        return np.asarray(white.T @ white)

    def whitened(self, columns: np.ndarray) -> np.ndarray:
        """L⁻¹ columns, shape (m,) or (m, k), of all readings or of the first m."""
        lower = self._of_first(len(columns))
        return np.asarray(scipy.linalg.solve_triangular(lower, columns, lower=True))

    def weighed(self, residual: np.ndarray) -> np.ndarray:
        """C⁻¹ r of a residual r, shape (m,), of all readings or of the first m."""
        return np.asarray(scipy.linalg.cho_solve((self._of_first(len(residual)), True), residual))

    def _of_first(self, count: int) -> np.ndarray:
        """L of so many readings, the first ones."""
        return self._lower[:count, :count]


def taken(change: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """How much of a change other numbers take over, in standard deviations of each, shape (k,).

    Args:
        change: of the readings, by their noise, shape (n,).
        columns: changes by one standard deviation of each number, shape (n, k). Their priors let
            them follow as far as that.
    """
    inner = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(inner, columns.T @ change))

"""The covariance of a residual: noise, nuisances and the error of the mesh.

C = Σ + N P Nᵀ + D Dᵀ = L Lᵀ, and L⁻¹ makes readings independent and of variance 1 ("whitens" them).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_triangular

Matrix = np.ndarray
Vector = np.ndarray


@dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of n readings, by its Cholesky factor.

    Attributes:
        factor: L, shape (n, n), lower triangular.
    """

    factor: Matrix

    @classmethod
    def of(cls, matrix: Matrix) -> Covariance:
        """From the matrix itself, shape (n, n).

        Raises:
            ValueError: one line, where it is not positive definite.
        """
        try:
            return cls(cholesky(matrix, lower=True))
        except LinAlgError:
            raise ValueError(
                "covariance is not positive definite: a reading has no independent noise"
            ) from None

    def __len__(self) -> int:
        return len(self.factor)

    @property
    def matrix(self) -> Matrix:
        """C, shape (n, n)."""
        return np.asarray(self.factor @ self.factor.T)

    @cached_property
    def logdet(self) -> float:
        """ln |C|."""
        return float(2 * np.log(np.diag(self.factor)).sum())

    def whiten(self, columns: Matrix) -> Matrix:
        """L⁻¹ columns, for shapes (n,) or (n, k)."""
        return np.asarray(solve_triangular(self.factor, columns, lower=True, check_finite=False))

    def log_density(self, residual: Vector) -> float:
        """Logarithm of the normal density N(residual; 0, C)."""
        white = self.whiten(residual)
        return float(-0.5 * (white @ white + self.logdet + len(self) * np.log(2 * np.pi)))

    def widened(self, columns: Matrix) -> Covariance:
        """C + columns columnsᵀ, for columns of shape (n, k) or (n,)."""
        extra = columns.reshape(len(self), -1)
        return Covariance.of(self.matrix + extra @ extra.T)

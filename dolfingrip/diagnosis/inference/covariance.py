"""The covariance of a residual: noise, nuisances and the error of the mesh.

C = Σ + N P Nᵀ + D Dᵀ = L Lᵀ, and L⁻¹ makes readings independent and of variance 1 ("whitens" them).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_triangular

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector

MESH_SHARE = 0.3
"""Part of (graded − ungraded mesh) that stands for the error which the graded mesh still has."""


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

    def sample(self, rng: np.random.Generator, count: int) -> Matrix:
        """Draws from N(0, C), shape (n, count)."""
        return np.asarray(self.factor @ rng.standard_normal((len(self), count)))

    def widened(self, columns: Matrix) -> Covariance:
        """C + columns columnsᵀ, for columns of shape (n, k) or (n,)."""
        extra = columns.reshape(len(self), -1)
        return Covariance.of(self.matrix + extra @ extra.T)


def total_covariance(
    noise: Matrix,
    nuisances: Matrix | None = None,
    spreads: Vector | None = None,
    mesh: Matrix | None = None,
    mesh_share: float = MESH_SHARE,
) -> Covariance:
    """C = Σ + N P Nᵀ + D Dᵀ.

    Args:
        noise: Σ, shape (n, n).
        nuisances: N, shape (n, k): change of all readings for each unit of a nuisance.
        spreads: standard deviations of the nuisances, shape (k,); 1 each where None.
        mesh: graded − ungraded readings, shape (n,) or (n, l).
        mesh_share: D = mesh_share × mesh.
    """
    matrix = noise.copy()
    if nuisances is not None and nuisances.size:
        scaled = nuisances if spreads is None else nuisances * spreads
        matrix += scaled @ scaled.T
    if mesh is not None and mesh.size:
        scaled = mesh_share * mesh.reshape(len(noise), -1)
        matrix += scaled @ scaled.T
    return Covariance.of(matrix)


def columns_by_group(columns: Matrix, group: Sequence[object]) -> Matrix:
    """Each column once for each group, zero elsewhere: scatter from specimen to specimen.

    Args:
        columns: shape (n, k), e.g. the change of all readings by one standard deviation of the
            modulus from finger to finger.
        group: the specimen of each reading, n of them.

    Returns:
        Shape (n, k × groups).
    """
    labels = np.asarray(group, dtype=object)
    parts = [columns * (labels == name)[:, None] for name in dict.fromkeys(group)]
    return np.hstack(parts)

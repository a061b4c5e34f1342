"""Names of array types, and sums of numbers that are known by their logarithms."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.special import logsumexp

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


def log_mean_exp(logs: npt.ArrayLike, axis: int = 0) -> Vector:
    """Logarithm of the mean of exp(logs) along an axis."""
    values = np.asarray(logs, dtype=float)
    return np.asarray(logsumexp(values, axis=axis) - np.log(values.shape[axis]))


def unit(columns: Matrix) -> Matrix:
    """Columns of length 1, or 0 where they are 0, for shapes (n,) or (n, k)."""
    length = np.linalg.norm(columns, axis=0)
    return np.asarray(columns / np.where(length > 0, length, 1.0))

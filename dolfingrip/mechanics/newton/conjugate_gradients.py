"""Conjugate gradients for several right-hand sides at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.newton.policy import CHOLESKY


def conjugate_gradients(
    matrix: PETSc.Mat,
    inverse: Callable[[np.ndarray], np.ndarray],
    right: np.ndarray,
    rtol: float,
) -> np.ndarray | None:
    """Solutions with a definite matrix, by preconditioned conjugate gradients.

    The preconditioner may be rounded: a step is conjugate to the one before for any (Golub & Ye,
    SIAM J. Sci. Comput. 21, 1999).

    Args:
        matrix: the matrix, on one rank.
        inverse: returns nearly the solutions for (n, k) right-hand sides.
        right: (n, k) right-hand sides.
        rtol: largest error in the norm of the energy, relative to the solution.

    Returns:
        (n, k) solutions; None if they are not found, as with a matrix that is not definite.
    """
    found, left = np.zeros_like(right), right.copy()
    step = np.array(inverse(left), dtype=float)
    energy = first = _products(left, step)
    for _ in range(CHOLESKY.iterations):
        rising = _times(matrix, step)
        curvature = _products(step, rising)
        if (curvature < 0).any():
            return None
        length = np.divide(energy, curvature, out=np.zeros_like(energy), where=curvature > 0)
        found += length * step
        left -= length * rising
        next_step = inverse(left)
        before, energy = energy, _products(left, next_step)
        if (energy <= rtol**2 * first).all():
            return found
        turned = -length * _products(rising, next_step)
        step *= np.divide(turned, before, out=np.zeros_like(turned), where=before > 0)
        step += next_step
    return None


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("nk,nk->k", a, b))


def _times(matrix: PETSc.Mat, columns: np.ndarray) -> np.ndarray:
    """The matrix times (n, k) columns."""
    x, y = matrix.createVecs()
    found = np.empty_like(columns)
    for column in range(columns.shape[1]):
        x.array[:] = columns[:, column]
        matrix.mult(x, y)
        found[:, column] = y.array_r
    return found

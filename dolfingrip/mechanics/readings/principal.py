"""Principal values of symmetric tensors."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

SIX: Final = ([0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1])
"""Rows and columns of the entries of a symmetric tensor."""

NEARLY_DOUBLE: Final = -1 + 1e-6
"""Cosine of Smith's angle below which the two largest eigenvalues are nearly equal."""


def largest_eigenvalue(tensors: Any) -> Floats:
    """Return the largest eigenvalue of symmetric tensors.

    The closed form (Smith, Communications of the ACM 4, 1961) takes a fifth of LAPACK's time. It
    loses half of its digits where the two largest eigenvalues are equal; LAPACK takes these.

    Args:
        tensors: shape (…, 3, 3).

    Returns:
        Shape (…), in the unit of the tensors.

    >>> largest_eigenvalue(np.diag([1.0, 3.0, 2.0])).round(12)
    array(3.)
    """
    xx, yy, zz, yz, xz, xy = (tensors[..., i, j] for i, j in zip(*SIX, strict=True))
    mean = (xx + yy + zz) / 3
    x, y, z = xx - mean, yy - mean, zz - mean
    size = np.sqrt((x**2 + y**2 + z**2 + 2 * (yz**2 + xz**2 + xy**2)) / 6)
    half_det = (x * (y * z - yz**2) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz)) / 2
    cosine = half_det / np.where(size > 0, size, 1.0) ** 3
    largest = np.array(mean + 2 * size * np.cos(np.arccos(np.clip(cosine, -1, 1)) / 3))
    if (double := np.asarray(cosine < NEARLY_DOUBLE)).any():
        largest[double] = np.linalg.eigvalsh(tensors[double])[..., -1]
    return largest

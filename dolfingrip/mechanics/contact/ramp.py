"""The smoothed Coulomb law: the force of friction rises with slip up to its limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Ramp:
    """f0, whose derivative rises as 2t − t², t = |s|/ε, to 1 at t = 1, and stays there.

    Li et al., Incremental Potential Contact, ACM Trans. Graph. 39, 2020, eq. 13.

    Attributes:
        slip_mm: ε.
    """

    slip_mm: float

    def value(self, size: np.ndarray) -> np.ndarray:
        """f0(|s|) (mm)."""
        t = np.minimum(size / self.slip_mm, 1.0)
        return np.asarray(self.slip_mm * (t**2 - t**3 / 3) + np.maximum(size - self.slip_mm, 0.0))

    def per_slip(self, size: np.ndarray) -> np.ndarray:
        """f0'(|s|)/|s| (1/mm)."""
        within = (2 - size / self.slip_mm) / self.slip_mm
        return np.where(size < self.slip_mm, within, 1 / np.maximum(size, self.slip_mm))

    def curvature(
        self, slip: np.ndarray, limit_N: np.ndarray, normals: np.ndarray, *, convex: bool = False
    ) -> np.ndarray:
        """(m, 3, 3) second derivatives (N/mm) of limits (m,) times f0 in planes with given normals.

        D = μN [a P + (f0'' − a) ŝ ŝᵀ] for each pair, a = f0'/|s| and f0'' = 2 (1 − |s|/ε)/ε.

        Args:
            slip: (m, 3) slip of the pairs (mm).
            limit_N: (m,) limits μN.
            normals: (m, 3) normals of the tangent planes.
            convex: whether it is μN a P, for the parabola in s that touches f0 and lies above it.
        """
        size = size_of(slip)
        per_slip = self.per_slip(size)
        plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
        blocks = per_slip[:, None, None] * plane
        if not convex:
            curvature = 2 * np.maximum(1 - size / self.slip_mm, 0.0) / self.slip_mm
            along = slip / np.maximum(size, np.finfo(float).tiny)[:, None]
            blocks += (curvature - per_slip)[:, None, None] * along[:, :, None] * along[:, None, :]
        return np.asarray(limit_N[:, None, None] * blocks)


def size_of(slip: np.ndarray) -> np.ndarray:
    """(m,) lengths of (m, 3) vectors."""
    return np.asarray(np.linalg.norm(slip, axis=1))

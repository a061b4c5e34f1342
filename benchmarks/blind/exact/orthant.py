"""Probability that both of two normal numbers are above 0, by its logarithm.

P = ∫₀^∞ N(x; μ₁, σ₁²) Φ((μ₂ + ρ σ₂ (x − μ₁)/σ₁) / (σ₂ √(1 − ρ²))) dx. The integrand is
log-concave, so one maximum and panels graded towards it are enough, however small P is.
"""

from __future__ import annotations

import numpy as np
from scipy.special import log_ndtr, logsumexp

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
BISECTIONS = 60
GRADING = np.concatenate([[0.0], 2.0 ** np.arange(-2, 22)])
"""Ends of panels away from the maximum, in its width."""
LARGEST_CORRELATION = 1 - 1e-9


def log_both_positive(mean: Matrix, covariance: Matrix) -> Vector:
    """ln P(x > 0 and y > 0) for many pairs (x, y) at once.

    Args:
        mean: shape (k, 2).
        covariance: shape (k, 2, 2), positive definite.

    Returns:
        Shape (k,), to some 1e-10.
    """
    std = np.sqrt(np.stack([covariance[:, 0, 0], covariance[:, 1, 1]], axis=1))
    correlation = np.clip(
        covariance[:, 0, 1] / std.prod(axis=1), -LARGEST_CORRELATION, LARGEST_CORRELATION
    )
    # in units of the standard deviations; x from −m₁ on, with Φ(c + d x)
    m1, m2 = (mean / std).T
    root = np.sqrt(1 - correlation**2)
    c, d = m2 / root, correlation / root
    lower = -m1
    mode = _mode(lower, c, d)
    inner = c + d * mode
    hazard = np.exp(-0.5 * inner**2 - 0.5 * np.log(2 * np.pi) - log_ndtr(inner))
    curvature = 1 + d**2 * hazard * (hazard + inner)
    slope = np.abs(-mode + d * hazard)
    width = 1 / np.maximum(np.sqrt(curvature), slope)
    right = mode[:, None] + width[:, None] * GRADING
    left = np.maximum(mode[:, None] - width[:, None] * GRADING[::-1], lower[:, None])
    ends = np.concatenate([left, right[:, 1:]], axis=1)
    half = 0.5 * np.diff(ends, axis=1)
    points = (0.5 * (ends[:, 1:] + ends[:, :-1]))[..., None] + half[..., None] * NODES
    logs = -0.5 * points**2 + log_ndtr(c[:, None, None] + d[:, None, None] * points)
    total = logsumexp(logs, axis=(1, 2), b=half[..., None] * WEIGHTS)
    return np.asarray(total - 0.5 * np.log(2 * np.pi))


def _mode(lower: Vector, c: Vector, d: Vector) -> Vector:
    """Where −x²/2 + ln Φ(c + d x) is largest on x ≥ lower; its slope falls monotonically."""

    def slope(x: Vector) -> Vector:
        inner = c + d * x
        hazard = np.exp(-0.5 * inner**2 - 0.5 * np.log(2 * np.pi) - log_ndtr(inner))
        return -x + d * hazard

    low = lower.copy()
    high = np.maximum(lower, 0.0) + 1.0
    for _ in range(BISECTIONS):
        rising = slope(high) > 0
        if not rising.any():
            break
        high = np.where(rising, 2 * high + 1, high)
    # the slope is positive at low, unless the maximum is there
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        rising = slope(middle) > 0
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return np.asarray(0.5 * (low + high))

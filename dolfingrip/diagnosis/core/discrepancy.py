"""A process for what no effect of the catalogue is: an always-possible discrepancy.

    K = S² {½ [k_SE(x, x′)]₀ + ¼ [k_M(s, s′)]₀ + ⅛ [k_E(x, x′)]₀ + ⅛ [k_E(s, s′)]₀}
    [k(a, b)]₀ = k(a, b) − k(a, 0) k(0, b)

x is the load by the largest, s the path Σ|Δx| of the load plus the logarithm of waits, S the root
mean square of a channel (Kennedy & O'Hagan, J. R. Stat. Soc. B 63, 2001). k_SE is a squared
exponential, k_M a Matérn kernel of order 3/2, k_E an exponential one. So the process is 0 at rest,
is smooth along the load, may differ between branches, cycles and waits, and may jump and waver:
without the last two a slip or a crosshead's uneven screw is taken for whichever effect follows a
little of it. Readings of another channel or another protocol have their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dolfingrip.diagnosis.policy import POLICY


@dataclass(frozen=True, eq=False)
class Along:
    """Where readings lie.

    Attributes:
        load: x, shape (n,).
        path: s, shape (n,).
        block: number of the channel and protocol of each, shape (n,).
        size: S of its channel, shape (n,).
    """

    load: np.ndarray
    path: np.ndarray
    block: np.ndarray
    size: np.ndarray


def kernel(along: Along) -> np.ndarray:
    """K for a level of 1, shape (n, n)."""
    x, s = along.load / POLICY.load_length, along.path / POLICY.path_length
    parts = (
        0.5 * _at_rest_zero(_squared_exponential, x)
        + 0.25 * _at_rest_zero(_matern, s)
        + 0.125 * _at_rest_zero(_exponential, along.load / POLICY.rough_length)
        + 0.125 * _at_rest_zero(_exponential, along.path / POLICY.rough_length)
    )
    same = along.block[:, None] == along.block
    return np.asarray(np.outer(along.size, along.size) * np.where(same, parts, 0.0))


def _at_rest_zero(k: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    return k(at[:, None] - at) - np.outer(k(at), k(at))


def _exponential(t: np.ndarray) -> np.ndarray:
    return np.exp(-np.abs(t))


def _squared_exponential(t: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * t**2)


def _matern(t: np.ndarray) -> np.ndarray:
    t = np.sqrt(3.0) * np.abs(t)
    return (1 + t) * np.exp(-t)


def path_of(load: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """s of one run's rows in the order of time, shape (rows,)."""
    moved = np.abs(np.diff(load, prepend=0.0))
    waited = np.where(moved > 1e-3, 0.0, np.diff(time_s, prepend=time_s[0]))
    since = np.zeros(len(load))
    for i in range(1, len(load)):
        since[i] = since[i - 1] + waited[i] if waited[i] > 0 else 0.0
    slow = POLICY.wait_weight * np.log1p(since / POLICY.wait_s)
    rise = np.maximum(np.diff(slow, prepend=0.0), 0.0)
    return np.asarray(np.cumsum(moved + rise))

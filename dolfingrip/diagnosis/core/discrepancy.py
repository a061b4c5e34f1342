"""A process for what no effect of the catalogue is: an always-possible discrepancy.

    K = ½ S² {k_SE(x, x′) − k_SE(x, 0) k_SE(0, x′) + k_M(s, s′) − k_M(s, 0) k_M(0, s′)}

x is the load by the largest, s the path Σ|Δx| of the load plus the logarithm of waits, S the root
mean square of a channel (Kennedy & O'Hagan, J. R. Stat. Soc. B 63, 2001). k_SE is a squared
exponential, k_M a Matérn kernel of order 3/2. So the process is 0 at rest, is smooth along the load
and may differ between branches, cycles and waits. Readings of another channel or another protocol
have their own.
"""

from __future__ import annotations

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
    smooth = _squared_exponential(x[:, None] - x) - np.outer(
        _squared_exponential(x), _squared_exponential(x)
    )
    winding = _matern(s[:, None] - s) - np.outer(_matern(s), _matern(s))
    same = along.block[:, None] == along.block
    return np.asarray(
        0.5 * np.outer(along.size, along.size) * np.where(same, smooth + winding, 0.0)
    )


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

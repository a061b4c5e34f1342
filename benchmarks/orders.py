"""Extrapolation to the converged value, and exponents of growth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

ORDERS = (0.5, 4.0)
"""Range in which an observed order is sought; sharp edges give about 1, smooth fields up to 4."""


@dataclass(frozen=True, slots=True)
class Limit:
    """The limit of values as the mesh is refined.

    Attributes:
        value: extrapolated.
        order: observed, NaN where the values do not converge monotonically.
        uncertainty: half the spread of the extrapolations that were tried.
    """

    value: float
    order: float
    uncertainty: float


def extrapolate(size: Sequence[float], value: Sequence[float]) -> Limit:
    """Limit of v(h) = v₀ + c hᵖ through the three finest meshes.

    Meshes without structure scatter about such a law, so the uncertainty comes from
    extrapolating the two finest with p = 1, 2 and with the order found.

    Args:
        size: element sizes in any unit, at least two, in any order.
        value: of each mesh.
    """
    order = np.argsort(size)
    h, v = np.asarray(size, dtype=float)[order], np.asarray(value, dtype=float)[order]
    tries = [_limit(h, v, 1.0), _limit(h, v, 2.0)]
    found = observed_order(h[:3], v[:3]) if len(h) > 2 else float("nan")
    best = float(np.mean(tries)) if np.isnan(found) else _limit(h, v, found)
    tries.append(best)
    return Limit(best, found, (max(tries) - min(tries)) / 2)


def _limit(h: np.ndarray, v: np.ndarray, p: float) -> float:
    """v₀ through the two finest."""
    return float(v[0] + (v[0] - v[1]) / ((h[1] / h[0]) ** p - 1))


def observed_order(h: np.ndarray, v: np.ndarray) -> float:
    """p of v₀ + c hᵖ through three meshes, finest first; NaN where there is none."""
    if v[0] == v[1]:
        return float("nan")
    ratio = (v[1] - v[2]) / (v[0] - v[1])

    def miss(p: float) -> float:
        return float((h[2] ** p - h[1] ** p) / (h[1] ** p - h[0] ** p) - ratio)

    if ratio <= 0 or miss(ORDERS[0]) * miss(ORDERS[1]) > 0:
        return float("nan")
    return float(brentq(miss, *ORDERS))


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of log y over log x by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])

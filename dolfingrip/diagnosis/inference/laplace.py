"""Parameters by numbers ζ that are standard normal before measuring.

A value is mean + spread ζ, or its log-normal counterpart of the same mean and spread.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.extensions.effect import Prior

MARGIN = 1e-3
"""Distance of the start from bounds, in ζ."""


@dataclass(frozen=True)
class Estimate:
    """A parameter after measuring, in its own unit.

    Attributes:
        value: most probable ζ's value.
        low, high: ends of the central 90 %.
        std_by_prior: standard deviation of ζ, 1 where the readings told nothing.
    """

    value: float
    low: float
    high: float
    std_by_prior: float


def to_values(priors: Iterable[Prior], zeta: Iterable[float]) -> list[float]:
    """Values of parameters."""
    return [prior.at(float(z)) for prior, z in zip(priors, zeta, strict=True)]


def zeta_bounds(
    priors: Sequence[Prior], bounds: Sequence[tuple[float, float]]
) -> tuple[Vector, Vector]:
    """Bounds of the values as bounds of ζ."""
    low, high = [], []
    for prior, (least, most) in zip(priors, bounds, strict=True):
        low.append(-math.inf if prior.positive and least <= 0 else prior.zeta(least))
        high.append(prior.zeta(most))
    return np.array(low), np.array(high)

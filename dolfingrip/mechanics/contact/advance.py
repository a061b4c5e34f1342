"""The safe part of a step of points towards a shape (conservative advancement).

Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, section 2.3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from dolfingrip.mechanics.contact.distance import Bounds
from dolfingrip.mechanics.contact.policy import ADVANCE


class Path(NamedTuple):
    """Points at one fraction of a step, in the shape's frame; each (n,), rates by the fraction.

    Attributes:
        distance: φ.
        slope: φ'.
        fastest: bound on the speed in the rest of the step.
        bend: bound on the acceleration in the rest of the step.
    """

    distance: np.ndarray
    slope: np.ndarray
    fastest: np.ndarray
    bend: np.ndarray


def reach(at: Callable[[float], Path], bounds: Bounds, kept: float = ADVANCE.kept) -> float:
    """The largest safe fraction of a step, 1 or less; each point keeps a part of its distance.

    With a shape's slope L and concavity κ, φ(t) ≥ φ + t φ' − t² (L A + κ v²)/2 as long as φ stays
    within the shape's reach, with bounds v and A on speed and acceleration, and φ(t) ≥ φ − t L v
    anywhere. The step is divided into pieces; each is as long as the better of these lower bounds
    allows.

    Args:
        at: returns the points at a fraction of the step.
        bounds: bounds of the shape.
        kept: the part of its distance that each point keeps.
    """
    path = at(0.0)
    if not len(path.distance):
        return 1.0
    least, reached = kept * path.distance, 0.0
    for _ in range(ADVANCE.pieces):
        ahead = _ahead(path, least, bounds)
        reached += ahead
        if reached >= 1.0:
            return 1.0
        if ahead < ADVANCE.kept * reached:
            break
        path = at(reached)
    return reached


def _ahead(path: Path, least: np.ndarray, bounds: Bounds) -> float:
    """Part of a step, 1 or less, in which all distances certainly stay above their minima."""
    spare = np.maximum(path.distance - least, 0.0)
    curved = bounds.slope * path.bend + bounds.concavity_per_mm * path.fastest**2
    safe = _until_spent(spare, path.slope, curved)
    if np.isfinite(bounds.reach_mm):
        most = bounds.slope * np.maximum(path.fastest, np.finfo(float).tiny)
        with np.errstate(over="ignore"):  # a point that stands still never gets there
            leaves = np.maximum(bounds.reach_mm - path.distance, 0.0) / most
            safe = np.maximum(np.minimum(safe, leaves), spare / most)
    return float(min(safe.min(initial=np.inf), 1.0))


def _until_spent(spare: np.ndarray, slope: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """(n,) smallest positive t at which spare + t slope − t² bend/2 vanishes."""
    root = np.sqrt(slope**2 + 2 * bend * spare)
    below = root - slope
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(below > 0, 2 * spare / below, np.inf)

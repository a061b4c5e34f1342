"""Whether contacts with friction can resist any load."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.optimize import linprog

EDGES: Final = 8
"""Number of edges of the pyramid that replaces a friction cone."""

CONTACTS: Final = 40
"""Number of contacts that are used; they have the largest normal forces."""


def margin(
    points_mm: np.ndarray,
    normals: np.ndarray,
    normal_N: np.ndarray,
    friction: float,
) -> float:
    """Force-closure margin of contacts; 0 if some load cannot be resisted.

    For a push along, or a turn about, each of the three axes in either direction there is a largest
    load that normal forces with a sum of 1 can bear within the friction pyramids: max t with
    Σ λ_j w_j = t e_k, Σ λ_j = 1, λ ≥ 0, a linear programme. The margin is the smallest of these
    loads. It is the size of the largest cross-polytope in the hull of the wrenches w_j; Ferrari and
    Canny (Planning Optimal Grasps, ICRA 1992) take a ball instead. Moments are divided by the
    points' spread. The margin of two hard opposite contacts is μ at most.

    Args:
        points_mm: (n, 3) places from the centre of gravity.
        normals: (n, 3) directions in which they push the object.
        normal_N: (n,) normal forces; the points with the largest ones are used.
        friction: μ.
    """
    hardest = np.argsort(normal_N)[::-1][:CONTACTS]
    if len(hardest) < 2:
        return 0.0
    wrenches = _wrenches(points_mm[hardest], normals[hardest], friction, EDGES)
    ways = [sign * np.eye(6)[k] for k in range(6) for sign in (1, -1)]
    return max(min(_borne(wrenches, way) for way in ways), 0.0)


def _borne(wrenches: np.ndarray, way: np.ndarray) -> float:
    """The largest t; 0 if there is none."""
    count = wrenches.shape[1]
    balance = np.hstack([wrenches, -way[:, None]])
    total = np.append(np.ones(count), 0.0)[None, :]
    optimum = linprog(
        np.append(np.zeros(count), -1.0),
        A_eq=np.vstack([balance, total]),
        b_eq=np.append(np.zeros(6), 1.0),
        bounds=(0, None),
        method="highs",
    )
    return float(-optimum.fun) if optimum.success else 0.0


def _wrenches(
    points_mm: np.ndarray, normals: np.ndarray, friction: float, edges: int
) -> np.ndarray:
    """Forces and moments of the pyramids' edges, moments by the points' spread, (6, n edges)."""
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    one = np.cross(normals, helper)
    one /= np.linalg.norm(one, axis=1)[:, None]
    other = np.cross(normals, one)
    length = max(float(np.sqrt((points_mm**2).sum(axis=1).mean())), 1e-9)
    wrenches = []
    for angle in 2 * np.pi * np.arange(edges) / edges:
        force = normals + friction * (np.cos(angle) * one + np.sin(angle) * other)
        wrenches.append(np.concatenate([force, np.cross(points_mm, force) / length], axis=1))
    return np.concatenate(wrenches).T

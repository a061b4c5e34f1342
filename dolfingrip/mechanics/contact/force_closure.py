"""Whether contacts with friction can resist any load."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

EDGES = 8
"""Of the pyramid that stands for a friction cone."""

MOST = 40
"""Contacts that are looked at: those that press hardest."""


def margin(
    points_mm: np.ndarray, normals: np.ndarray, normal_N: np.ndarray, friction: float
) -> float:
    """Force-closure margin of contacts, 0 (no closure) to 1.

    Wrenches w_j of the edges of all friction pyramids close by force where Σ λ_j w_j = 0 has a
    solution with all λ_j > 0 and they span all six dimensions (Murray, Li & Sastry, A Mathematical
    Introduction to Robotic Manipulation, 1994, prop. 5.3). The margin is the largest λ that all
    can have at least, with a mean of 1: a linear programme.

    Args:
        points_mm: (n, 3) places from the centre of gravity.
        normals: (n, 3) directions in which they push the object.
        normal_N: (n,) forces, by which the hardest are chosen.
        friction: μ.
    """
    hardest = np.argsort(normal_N)[::-1][:MOST]
    if len(hardest) < 2:
        return 0.0
    wrenches = _wrenches(points_mm[hardest], normals[hardest], friction)
    if np.linalg.matrix_rank(wrenches, tol=1e-9 * len(wrenches)) < 6:
        return 0.0
    count = wrenches.shape[1]
    # unknowns λ and the least of them, which is to be large
    balance = np.hstack([wrenches, np.zeros((6, 1))])
    total = np.append(np.ones(count), 0.0)[None, :]
    above = np.hstack([-np.eye(count), np.ones((count, 1))])
    found = linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=above,
        b_ub=np.zeros(count),
        A_eq=np.vstack([balance, total]),
        b_eq=np.append(np.zeros(6), count),
        bounds=(0, None),
        method="highs",
    )
    return float(max(-found.fun, 0.0)) if found.success else 0.0


def _wrenches(points_mm: np.ndarray, normals: np.ndarray, friction: float) -> np.ndarray:
    """(6, n edges) forces and moments of the pyramids' edges, moments by the points' spread."""
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    one = np.cross(normals, helper)
    one /= np.linalg.norm(one, axis=1)[:, None]
    other = np.cross(normals, one)
    length = max(float(np.sqrt((points_mm**2).sum(axis=1).mean())), 1e-9)
    found = []
    for angle in 2 * np.pi * np.arange(EDGES) / EDGES:
        force = normals + friction * (np.cos(angle) * one + np.sin(angle) * other)
        found.append(np.concatenate([force, np.cross(points_mm, force) / length], axis=1))
    return np.concatenate(found).T

"""What earlier designs tell of the next step: linear limits around it, and curvature."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dolfingrip.design.gradient.evaluation import Floats
from dolfingrip.design.gradient.policy import POLICY
from dolfingrip.design.gradient.subproblem import Rows
from dolfingrip.design.gradient.trial import Trial


def bundle(here: Trial, trials: Sequence[Trial], bend: Floats) -> Rows:
    """Limits of simulated quantities, linear at a design and at the last ones around it.

    A largest stretch is where two places take turns the largest of several functions. What it was
    at other designs tells of those; none of them may exclude the design itself.
    """
    rows = Rows(here.above, here.above_slopes, bend)
    around = [each for each in trials if each is not here and not each.failure]
    for other in around[-POLICY.bundle :]:
        values = other.above + other.above_slopes @ (here.scaled - other.scaled)
        rows = rows.with_rows(Rows(np.minimum(values, here.above), other.above_slopes, bend))
    return rows


def predicted_limits(rows: Rows, step: Floats, limits: int) -> Floats:
    """What a bundle of rows says of each of the limits after a step, shape (limits,)."""
    if not limits:
        return np.empty(0)
    every = (rows.values + rows.slopes @ step).reshape(-1, limits)
    return np.asarray(every.max(axis=0))


def bfgs_update(curvature: Floats, step: Floats, turn: Floats, *, fresh: bool) -> Floats:
    """The curvature after a step over which the gradient turned, by damped BFGS."""
    along = float(step @ turn)
    if fresh and along > 0:
        curvature = np.asarray(np.eye(len(step)) * along / float(step @ step), dtype=float)
    bent = curvature @ step
    size = float(step @ bent)
    if along < 0.2 * size:
        share = 0.8 * size / (size - along)
        turn = share * turn + (1 - share) * bent
        along = float(step @ turn)
    found = curvature - np.outer(bent, bent) / size + np.outer(turn, turn) / along
    return np.asarray((found + found.T) / 2)

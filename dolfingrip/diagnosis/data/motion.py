"""How a control moved in a test: ramps up and down, and waits, as its rows tell.

Laboratories name their rows in many ways: a regulator that steps and waits has rows called "hold",
"loading" or nothing. What a test did to the specimen stands in the control and the time alone, so
these decide, and the same rows lead to the same simulations whatever they are called.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb, sqrt

import numpy as np
import pandas as pd
from numpy.polynomial import Polynomial
from scipy.ndimage import label
from scipy.special import ndtri

from dolfingrip.diagnosis.policy import Policy


def smallest_change(value: np.ndarray, sigma: float, policy: Policy = Policy()) -> float:
    """Return the change of a control that is none of its gauge's noise.

    Args:
        value: (n,) control of each row (kPa or mm).
        sigma: standard deviation of the gauge as told, in the same unit; 0 where none is told.
        policy: what noise is.
    """
    return _change(value, _noise(value, sigma, policy), policy)


def travel(value: np.ndarray, sigma: float, policy: Policy = Policy()) -> np.ndarray:
    """Return how far a control went from each row to the next, without its gauge's noise.

    Between two turns the control is taken as where it has come to so far.

    Args:
        value: (n,) control of each row (kPa or mm), which begins at rest, or below.
        sigma: standard deviation of the gauge as told, in the same unit; 0 where none is told.
        policy: what noise is.

    Returns:
        (n,) in the same unit, the first of the way from rest.
    """
    here = min(0.0, float(value[0]))
    steps = np.zeros(len(value))
    for i, rises in enumerate(_rising(value, smallest_change(value, sigma, policy))):
        steps[i] = max((value[i] - here) * (1.0 if rises else -1.0), 0.0)
        here = value[i] if steps[i] else here
    return steps


def _change(value: np.ndarray, noise: float, policy: Policy) -> float:
    return max(10 * policy.gauge * _size(value), policy.certain * noise)


def _size(value: np.ndarray) -> float:
    return max(float(np.abs(value).max()), 1e-12)


def _noise(value: np.ndarray, sigma: float, policy: Policy) -> float:
    """Standard deviation of the gauge as told, or as dense rows show where that is more."""
    order = policy.differences
    if len(value) < policy.dense:
        return sigma
    steps = np.abs(np.diff(value, order)) / sqrt(comb(2 * order, order))
    most = 0.01 * _size(value) / 2  # a gauge is no worse than half a hundredth
    return max(sigma, min(float(np.median(steps)) / float(ndtri(1 - 0.25)), most))


def motion(
    values: Sequence[np.ndarray], time_s: np.ndarray, sigma: float, policy: Policy = Policy()
) -> pd.DataFrame:
    """Find ramps and waits in the rows of one test, or of one cycle of it.

    A row rests where it and its neighbours stay within the smallest change for longer than a ramp
    takes to come back to where it turned by such a change. The others move in the direction between
    two turns of the control. Of several controls a leg ends where that of any of them does, and has
    the branch of the one that moves farthest along it.

    Args:
        values: (n,) of each control (kPa or mm), in the order in which they were read.
        time_s: (n,) time of each row, rising.
        sigma: standard deviation of the controls' gauge; 0 where none is told.
        policy: what a ramp and a wait are.

    Returns:
        Of each row the ``branch``: ``loading`` (away from 0), ``unloading`` (back towards 0) or
        ``hold``; the ``leg``, which is the number of its ramp or wait, from 0 on; the ``cycle``,
        from 1 on: each begins where the control is loaded again, to a side of 0 that it was
        unloaded from in this cycle.
    """
    several = len(values) > 1
    legs = [_legs(value, time_s, sigma, policy, several=several) for value in values]
    branches = np.array([branch for branch, _ in legs])
    leg = np.cumsum(np.any([new for _, new in legs], axis=0))
    starts = np.flatnonzero(np.diff(leg, prepend=-1))
    leads = farthest(np.array(values), leg)
    branch = branches[leads[leg], np.arange(len(leg))]
    cycles, left = [1], set[bool]()
    for number, (name, start) in enumerate(zip(branch[starts], starts, strict=True)):
        value = values[leads[number]]
        end = [*starts[1:], len(leg)][number] - 1
        if name == "unloading":
            left.add(bool(value[max(start - 1, 0)] < 0))
        again = name == "loading" and bool(value[end] < 0) in left
        if again:
            left.clear()
        cycles.append(cycles[-1] + again)
    return pd.DataFrame({"branch": branch, "cycle": np.array(cycles[1:])[leg], "leg": leg})


def farthest(values: np.ndarray, leg: np.ndarray) -> np.ndarray:
    """Place (legs,) of the control that moves farthest along each leg, from the row before it on.

    Args:
        values: (controls, n) at each row.
        leg: (n,) number of each row's leg, from 0 on.
    """
    places = np.zeros(int(leg[-1]) + 1, dtype=int)
    for number in range(len(places)):
        rows = np.flatnonzero(leg == number)
        places[number] = np.ptp(values[:, max(rows[0] - 1, 0) : rows[-1] + 1], axis=1).argmax()
    return places


def _legs(
    value: np.ndarray, time_s: np.ndarray, sigma: float, policy: Policy, *, several: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Branch (n,) of each row by one control, or one of several, and whether a leg begins there."""
    noise = _noise(value, sigma, policy)
    change = _change(value, noise, policy)
    within = max(policy.gauge * _size(value), policy.rests * noise)
    rests = _resting(value, time_s, change, within, policy.waits)
    up = _rising(value, change)
    turns = np.flatnonzero(up[1:] != up[:-1])
    since = np.concatenate([[0.0], value[turns]])[np.searchsorted(turns, np.arange(len(value)))]
    way = np.where(up, 1.0, -1.0)
    back = (way * since < -change) & (way * value <= change)
    branch = np.where(rests, "hold", np.where(back, "unloading", "loading")).astype(object)
    jumped = np.concatenate([[False], np.abs(np.diff(value)) > change])
    # a way from one side of 0 to the other may have no row between; one control begins at rest
    away = (np.abs(value[:-1]) > change) | several
    beyond = (up[1:] != up[:-1]) & away & ~rests[1:]
    new = np.concatenate([[False], (branch[1:] != branch[:-1]) | beyond])
    return branch, new | (rests & jumped)


def _groups(value: np.ndarray, change: float) -> list[slice]:
    """Successive rows, as many as stay within a change of one another."""
    groups, first = [], 0
    low = high = value[0]
    for i, here in enumerate(value):
        low, high = min(low, here), max(high, here)
        if high - low > change:
            groups.append(slice(first, i))
            first, low, high = i, here, here
    return [*groups, slice(first, len(value))]


def _resting(
    value: np.ndarray, time_s: np.ndarray, change: float, within: float, longer: float
) -> np.ndarray:
    """Rows (n,) that belong to a wait, of which each is ``within`` of the others' middle.

    A ramp takes less than a wait for ``longer`` changes.
    """
    groups = _groups(value, change)
    means = np.array([value[group].mean() for group in groups])
    middle_s = np.array([time_s[group].mean() for group in groups])
    apart, later_s = np.abs(np.diff(means)), np.diff(middle_s)
    moving = (apart >= change / 2) & (later_s > 0)
    rate = float(np.median(apart[moving] / later_s[moving])) if moving.any() else np.inf
    waits = []
    for group in groups:
        lasts_s = float(np.ptp(time_s[group]))
        if not lasts_s > 0:  # or where nobody told times
            waits.append(False)
            continue
        slope = Polynomial.fit(time_s[group], value[group], 1).deriv()(0.0)
        waits.append(bool(abs(slope) * lasts_s <= change / 2 and lasts_s * rate >= longer * change))
    rests = np.zeros(len(value), dtype=bool)
    for group in (group for group, waited in zip(groups, waits, strict=True) if waited):
        # the first and last rows of a group may be a ramp's
        off = np.abs(value - np.median(value[group]))
        near = off <= (1 + 1e-3) * max(within, float(np.median(off[group])))
        inside = np.flatnonzero(near[group]) + group.start
        rests[inside[0] : inside[-1] + 1] = True
        run, _ = label(near)
        rests |= np.isin(run, run[inside[[0, -1]]])
    # what a ramp leads to is its last row
    starts = np.flatnonzero(rests[1:] & (~rests[:-1] | (np.abs(np.diff(value)) > change))) + 1
    rests[starts] = False
    return rests


def _rising(value: np.ndarray, change: float) -> np.ndarray:
    """Rows (n,) before which the control moved upwards; a turn is a way back by over a change."""
    up = np.zeros(len(value), dtype=bool)
    start, rises = 0, bool(value[0] >= -change)
    extreme, at = value[0], 0
    for i, here in enumerate(value):
        if (here >= extreme) == rises:
            extreme, at = here, i
        elif abs(here - extreme) > change:
            up[start : at + 1] = rises
            start, rises, extreme, at = at + 1, not rises, here, i
    up[start:] = rises
    return up

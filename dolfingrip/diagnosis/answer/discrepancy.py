"""A discrepancy of the model: a process for what no effect of the catalogue is.

    K = S² {½ [k_SE(x, x′)]₀ + ¼ [k_M(s, s′)]₀ + ⅛ [k_E(x, x′)]₀ + ⅛ [k_E(s, s′)]₀}
    [k(a, b)]₀ = k(a, b) − k(a, 0) k(0, b)

x is the load by the largest, s the path Σ|Δx| of the load plus the logarithm of waits, S the root
mean square of a channel (Kennedy & O'Hagan, J. R. Stat. Soc. B 63, 2001). k_SE is a squared
exponential, k_M a Matérn kernel of order 3/2, k_E an exponential one. So the process is 0 at rest,
is smooth along the load, may differ between branches, cycles and waits, and may jump and waver:
without the last two a slip or a crosshead's uneven screw is taken for whichever effect follows a
little of it. A body that moves goes on while the load rests: there s grows by 1 in a record's time.
Readings of another channel or another protocol have their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.polynomial import chebyshev

from dolfingrip.diagnosis.data.clock import moves
from dolfingrip.diagnosis.data.measurement import largest
from dolfingrip.diagnosis.finger import Simulator
from dolfingrip.diagnosis.policy import Policy


@dataclass(frozen=True, eq=False)
class Along:
    """Where readings lie.

    Attributes:
        load: x, shape (n,).
        path: s, shape (n,).
        block: number of the channel and protocol of each, shape (n,).
        size: S of its channel, shape (n,).
        policy: how far a discrepancy reaches along them.
    """

    load: np.ndarray
    path: np.ndarray
    block: np.ndarray
    size: np.ndarray
    policy: Policy = Policy()

    def at(self, some: np.ndarray) -> Along:
        """Where some of the readings lie."""
        parts = (self.load[some], self.path[some], self.block[some], self.size[some])
        return Along(*parts, self.policy)

    def ways(self, listed: pd.DataFrame) -> list[np.ndarray]:
        """Places of the readings of each branch of each cycle, by channel and protocol."""
        keys = [self.block, listed["cycle"].to_numpy(), listed["branch"].to_numpy()]
        return [*listed.reset_index(drop=True).groupby(keys, sort=False).indices.values()]


def lying(simulation: Simulator) -> Along:
    """Where a measurement's readings lie: loads by the largest of their experiment.

    The load of a coupon is its strain. Channels of tests that are simulated together share a
    discrepancy.
    """
    measurement = simulation.measurement
    listed, rows = measurement.listed, measurement.readings.reset_index(drop=True)
    load, path = np.zeros((2, len(rows)))
    of = rows.groupby("test").indices
    applied = measurement.applied(simulation.config)
    for test in measurement.tests:
        coupon = applied[test.number].coupon
        by = coupon.gauge_length_mm if test.experiment == "coupon" else 1.0
        load[of[test.number]] = rows[test.control].to_numpy()[of[test.number]] / by
    load /= largest(load, rows["experiment"].to_numpy())
    time_s = rows["time_s"].to_numpy()
    for number, mine in of.items():
        path[mine] = path_of(load[mine], time_s[mine], measurement.policy)
        if moves(applied[number]):
            path[mine] += (time_s[mine] - time_s[mine][0]) / max(np.ptp(time_s[mine]), 1e-12)
    group = {test: place for place, part in enumerate(simulation.groups) for test in part.tests}
    block = listed.groupby([listed["test"].map(group), "column"]).ngroup()
    size = np.sqrt((listed["value"] ** 2).groupby(block).transform("mean"))
    row = listed["row"].to_numpy()
    policy = measurement.policy
    return Along(load[row], path[row], block.to_numpy(), size.to_numpy(), policy)


def path_of(load: np.ndarray, time_s: np.ndarray, policy: Policy) -> np.ndarray:
    """s of one run's rows in the order of time, shape (rows,)."""
    moved = np.abs(np.diff(load, prepend=0.0))
    waited = np.where(moved > 1e-3, 0.0, np.diff(time_s, prepend=time_s[0]))
    since = np.zeros(len(load))
    for i in range(1, len(load)):
        since[i] = since[i - 1] + waited[i] if waited[i] > 0 else 0.0
    slow = policy.wait_weight * np.log1p(since / policy.wait_s)
    rise = np.maximum(np.diff(slow, prepend=0.0), 0.0)
    return np.asarray(np.cumsum(moved + rise))


def kernel(along: Along) -> np.ndarray:
    """K for a level of 1, shape (n, n)."""
    x, s, length = along.load, along.path, along.policy.load_length
    steep = np.sqrt(2 * (1 + 0.5))  # √(2ν) of a Matérn kernel of order ν = 3/2
    parts = (
        0.5 * _at_rest_zero(lambda t: np.exp(-0.5 * t**2), x / length)
        + 0.25 * _at_rest_zero(lambda t: (1 + steep * t) * np.exp(-steep * t), s)
        + 0.125 * _at_rest_zero(lambda t: np.exp(-t), x / length)
        + 0.125 * _at_rest_zero(lambda t: np.exp(-t), s / length)
    )
    same = along.block[:, None] == along.block
    return np.asarray(np.outer(along.size, along.size) * np.where(same, parts, 0.0))


def _at_rest_zero(k: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """[k]₀ of a kernel by the distance."""
    to_rest = k(np.abs(at))
    return k(np.abs(at[:, None] - at)) - np.outer(to_rest, to_rest)


def smooth_curves(along: Along) -> np.ndarray:
    """Columns of any smooth curve of the load in each channel, as free as its size, (n, k)."""
    columns = []
    for block in np.unique(along.block):
        mine = along.block == block
        shapes = chebyshev.chebvander(2 * along.load - 1, along.policy.smooth - 1)
        columns.append((mine * along.load * along.size)[:, None] * shapes)
    return np.hstack(columns)

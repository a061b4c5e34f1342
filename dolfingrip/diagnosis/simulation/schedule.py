"""The stops of a simulation, and how measured rows are read between them.

An interpolant has successive stops of one branch, and the rows that are read between them.

Readings at rows are weighted sums of those at stops, y_rows = W y_stops, by a cubic spline through
its stops in the control (in the logarithm of time where that rests). A row that is a stop has
that stop's reading itself. Beyond the ends a straight line goes on. W does not depend on what is
interpolated, so changes and derivatives are interpolated as the readings themselves are.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

from dolfingrip.diagnosis.policy import ROUTES


@dataclass(frozen=True, slots=True)
class StopInterpolant:
    """Stops and rows along one branch.

    Attributes:
        stops: places of the stops in the simulation's list.
        at: of each stop, what the leg is read by: pressure (kPa), travel (mm), or in a wait a
            logarithm of time.
        rows: places of the rows in ``Measurement.readings``.
        rows_at: of each row.
        core: how many of the stops rows are read from up to the last of them; the others are for
            rows beyond. 0: all. So a curve with headroom gives the same there as one without.
    """

    stops: np.ndarray
    at: np.ndarray
    rows: np.ndarray
    rows_at: np.ndarray
    core: int = 0

    def weights(
        self, reached: int, rows_at: np.ndarray | None = None, outside: float = ROUTES.outside
    ) -> np.ndarray:
        """(rows, stops) weights with the first ``reached`` stops of the simulation.

        Args:
            reached: number of stops that there are readings of; the rest have no weight.
            rows_at: in place of the leg's own.
            outside: how far beyond the stops that were reached rows are read.

        Returns:
            NaN in the rows that cannot be read, as the simulation did not come so far.
        """
        where = self.rows_at if rows_at is None else rows_at
        return self._spread(where, reached, 0, outside)

    def read(self, values: np.ndarray, at: np.ndarray) -> np.ndarray:
        """(places,) readings at any place, however far beyond the leg.

        Args:
            values: (reached,) of one column, at the first stops of the simulation.
            at: (places,) by what the leg is read by.
        """
        padded = np.pad(values, (0, len(self.stops) - len(values)))
        return np.asarray(self.weights(len(values), at, ROUTES.anywhere) @ padded)

    def slopes(self, reached: int) -> np.ndarray:
        """(rows, stops) weights of the derivative by what the leg is read by."""
        return self._spread(self.rows_at, reached, 1)

    def _spread(
        self, where: np.ndarray, reached: int, derivative: int, outside: float = ROUTES.outside
    ) -> np.ndarray:
        there = np.flatnonzero(self.stops < reached)
        found = np.zeros((len(where), len(self.stops)))
        if not there.size:
            found[:] = np.nan
            return found
        found[:, there] = _spline_weights(self.at[there], where, derivative)
        if 0 < self.core < there.size:
            own = there[: self.core]
            inside = where <= self.at[own].max()
            found[inside] = 0.0
            found[np.ix_(inside, own)] = _spline_weights(self.at[own], where[inside], derivative)
        if there.size < len(self.stops):
            low, high = self.at[there].min(), self.at[there].max()
            margin = outside * (high - low)
            found[(where > high + margin) | (where < low - margin)] = np.nan
        return found


def _spline_weights(at: np.ndarray, where: np.ndarray, derivative: int) -> np.ndarray:
    """(where, at) weights of a value, or of a derivative."""
    if len(set(at.tolist())) == 1:
        found = np.zeros((len(where), len(at)))
        found[:, -1] = float(derivative == 0)
        return found
    spline = _spline(tuple(at.tolist()))
    x = spline.x
    inside = np.clip(where, x[0], x[-1])
    slopes = np.asarray(spline(inside, 1))
    if derivative:
        return slopes
    return np.asarray(spline(inside) + (where - inside)[:, None] * slopes)


@functools.lru_cache(maxsize=1024)  # a fit reads the same stops anew for each modulus that it tries
def _spline(at: tuple[float, ...]) -> CubicSpline:
    """Column j: through 1 at stop j and 0 at the others; a line or parabola for 2 or 3 stops."""
    # of stops at one place, as between two cycles at rest, the last one counts
    places, last = np.unique(np.array(at)[::-1], return_index=True)
    return CubicSpline(places, np.eye(len(at))[len(at) - 1 - last])


@dataclass(frozen=True, slots=True)
class StopSchedule:
    """All stops of a simulation, in order, and its legs.

    Attributes:
        control: column of the control.
        time_s, value, cycle, branch: of each stop.
        legs: every measured row is on one of them.
        others: values of further controls at each stop, by column.
    """

    control: str
    time_s: tuple[float, ...]
    value: tuple[float, ...]
    cycle: tuple[int, ...]
    branch: tuple[str, ...]
    legs: tuple[StopInterpolant, ...]
    others: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def protocol(self) -> dict[str, object]:
        """The protocol's columns; :func:`protocol_file.key` tells where they belong."""
        return {
            **{name: list(own) for name, own in self.others.items()},
            "time_s": list(self.time_s),
            self.control: list(self.value),
            "cycle": list(self.cycle),
            "branch": list(self.branch),
        }

    def at_rows(self, values: np.ndarray, count: int) -> np.ndarray:
        """Readings at the measured rows from those at the stops.

        Args:
            values: (reached,) of one column, at the stops that were reached.
            count: number of rows of the measurement.

        Returns:
            (count,) NaN in rows that are not on this route or were not reached.
        """
        return self._spread(values, count, [leg.weights(len(values)) for leg in self.legs])

    def slopes(self, values: np.ndarray, count: int) -> np.ndarray:
        """Derivatives of the readings at the measured rows by the control; 0 where that rests."""
        weights = []
        for leg in self.legs:
            rests = self.branch[int(leg.stops[-1])] == "hold"
            weights.append(leg.slopes(len(values)) * float(not rests))
        return self._spread(values, count, weights)

    def _spread(self, values: np.ndarray, count: int, weights: Sequence[np.ndarray]) -> np.ndarray:
        found = np.full(count, np.nan)
        padded = np.pad(values, (0, len(self.value) - len(values)))
        for leg, weight in zip(self.legs, weights, strict=True):
            found[leg.rows] = weight @ padded[leg.stops]
        return found

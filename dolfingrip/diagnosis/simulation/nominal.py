"""Stops at round values on straight ramps: where the laboratory meant to stop, not where it read.

A gauge's noise is no motion of the finger. Two measurements with like controls then ask for the
same simulations, so that the second finds them in the store; and a ramp at one rate takes half the
iterations of one that changes its rate at every stop, as the load path's prediction goes on.
Rows are read between the stops at the pressure that was read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from dolfingrip.diagnosis.policy import ROUTES


class NominalStop(NamedTuple):
    """Where a test is simulated.

    Attributes:
        time_s, cycle, branch: of the stop.
        value: of the control that leads its segment.
        controls: values of all controls, by column.
    """

    time_s: float
    value: float
    cycle: int
    branch: str
    controls: Mapping[str, float] = MappingProxyType({})


def unit_for(distance: float) -> float:
    """The largest of 1, 2, 5 times a power of ten up to a part of a distance."""
    most = distance / ROUTES.fineness
    power = 10.0 ** math.floor(math.log10(most) + 1e-9)
    return power * max(step for step in (1.0, 2.0, 5.0) if step * power <= most * (1 + 1e-9))


def common_unit(read: np.ndarray, sigma: float) -> float:
    """Return the unit that the places of a laboratory's stops are multiples of.

    It is the largest of 1, 2, 2.5, 5 times a power of ten that all readings of the gauge are within
    its noise of, and that its noise does not reach half of. So like data have the same stops. Where
    there is none, the stops' distance tells how fine the unit is; it is never finer than that.

    Args:
        read: (n,) stops as read, of which no two are the same.
        sigma: standard deviation of the gauge, above 0.
    """
    distance = abs(float(read[-1] - read[0])) / (len(read) - 1)
    power = 10.0 ** math.floor(math.log10(distance) + 1e-9)
    finest = unit_for(distance)
    for unit in (step * power for step in (5.0, 2.5, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)):
        within = min(ROUTES.certain * sigma, ROUTES.clear * unit)
        plausible = max(finest, ROUTES.tells * sigma) <= unit <= distance * (1 + ROUTES.alike)
        if plausible and np.abs(read - unit * np.round(read / unit)).max() <= within:
            return unit
    return finest


def rounded(value: float, unit: float) -> float:
    """The nearest multiple of a unit."""
    return float(f"{round(value / unit) * unit:.9g}")


def end(value: float, distance: float, sigma: float) -> float:
    """A turn, a wait: the round value if the gauge's noise allows, else as it was read."""
    if not (sigma and distance > 0):
        return value
    meant = rounded(value, unit_for(distance))
    return meant if abs(meant - value) <= ROUTES.certain * sigma else value


def values(read: np.ndarray, sigma: float) -> np.ndarray:
    """Round rising values of a control, the last by :func:`end`.

    Args:
        read: (n,) values as read, rising.
        sigma: standard deviation of the gauge; nothing is rounded where it is 0.

    Returns:
        (m,) round values.
    """
    if len(read) < 2 or not sigma:
        return read
    distance = float(read[-1] - read[0]) / (len(read) - 1)
    unit, last = common_unit(read, sigma), end(float(read[-1]), distance, sigma)
    inner = dict.fromkeys(rounded(float(value), unit) for value in read[:-1])
    return np.array([*(value for value in inner if value < last), last])


def ramp(
    found: Sequence[NominalStop], before: NominalStop | None, sigma: float, leads_to: float
) -> list[NominalStop]:
    """The stops of a ramp at round values, at one rate where its rows allow.

    Args:
        found: its stops as read, the values rise or fall.
        before: the stop that it starts from; None at the start of a test.
        sigma: standard deviation of the gauge; nothing is changed where it is 0.
        leads_to: value of the wait that follows, where the ramp ends exactly; NaN without one.
    """
    known = [*([before] if before else []), *found]
    if not sigma or len(known) < 3:
        return list(found)
    time_s = np.array([stop.time_s for stop in known])
    read = np.array([stop.value for stop in known])
    distance = abs(float(read[-1] - read[0])) / (len(read) - 1)
    if not distance:
        return list(found)
    unit = common_unit(read, sigma)
    meant = np.array([rounded(float(value), unit) for value in read])
    meant[-1] = leads_to if not math.isnan(leads_to) else end(float(read[-1]), distance, sigma)
    meant[0] = before.value if before else end(float(read[0]), distance, sigma)
    rises = meant[-1] > meant[0]
    ends = [0, -1] if rises else [-1, 0]
    line_s = np.interp(meant, meant[ends], time_s[ends])
    whole_s = float(time_s[-1] - time_s[0])
    if np.abs(line_s - time_s).max() <= ROUTES.straight * whole_s:
        time_s = line_s
    way = 1.0 if rises else -1.0
    kept = [0]
    for i in range(1, len(meant) - 1):
        if way * (meant[i] - meant[kept[-1]]) > 0 and way * (meant[-1] - meant[i]) > 0:
            kept.append(i)
    kept.append(len(meant) - 1)
    first = 1 if before else 0
    return [
        found[0]._replace(time_s=float(f"{time_s[i]:.9g}"), value=float(meant[i]))
        for i in kept[first:]
    ]

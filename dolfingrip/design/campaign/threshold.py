"""The least value at which something succeeds, on a grid, by few and costly trials."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Threshold(NamedTuple):
    """Two neighbours on the grid, or a range's end.

    Attributes:
        fails: largest place that failed below; None where the lowest one allowed succeeds.
        succeeds: that least place; None where the highest one allowed fails.
    """

    fails: int | None
    succeeds: int | None


def least(passes: Callable[[int], bool], start: int, low: int, high: int) -> Threshold:
    """The least place of a grid at which a trial succeeds, from ``start`` on.

    Strides double until a success and a failure lie on either side; halving them leaves neighbours.
    So a start that is near costs two trials. Where success does not rise with the place, it is the
    boundary nearest to the start in the direction of the first trial.

    Args:
        passes: a trial at a place.
        start: of the search, moved to between ``low`` and ``high``.
        low: least place.
        high: largest place.
    """
    place = min(max(start, low), high)
    if passes(place):
        fails, succeeds = _downwards(passes, place, low)
    else:
        fails, succeeds = _upwards(passes, place, high)
    while fails is not None and succeeds is not None and succeeds - fails > 1:
        middle = (fails + succeeds) // 2
        if passes(middle):
            succeeds = middle
        else:
            fails = middle
    return Threshold(fails, succeeds)


def _downwards(passes: Callable[[int], bool], place: int, low: int) -> Threshold:
    """From a success."""
    stride = 1
    while place > low:
        lower = max(place - stride, low)
        if not passes(lower):
            return Threshold(lower, place)
        place, stride = lower, 2 * stride
    return Threshold(None, place)


def _upwards(passes: Callable[[int], bool], place: int, high: int) -> Threshold:
    """From a failure."""
    stride = 1
    while place < high:
        higher = min(place + stride, high)
        if passes(higher):
            return Threshold(place, higher)
        place, stride = higher, 2 * stride
    return Threshold(place, None)

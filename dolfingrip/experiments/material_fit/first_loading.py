"""First loading of a coupon, found in its readings where no column tells it."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
from scipy.ndimage import median_filter

TURN: Final = 0.02
"""Part of the farthest way by which a coupon goes back before the way back has begun."""

FALL: Final = 0.1
"""Part of the load by which it falls at a slip or a break."""

NOISES: Final = 20.0
"""Times the median distance of a reading from the median of three, within which noise stays."""

UNORDERED: Final = 0.5
"""Noise, as a part of the farthest way, from which on a table has no order."""

FLAT: Final = 0.95
"""Strain to which nothing is pressed."""

STEEPER: Final = 1.1
"""Growth of the tangent from the first to the last quarter, above which no noise makes it."""

NEXT_TO_NOTHING: Final = 0.02
"""Part of the largest load up to which a coupon may be slack."""

SLACK: Final = 0.04
"""Part of the farthest way from which on that is told."""


def first_loading(stretch: np.ndarray, stress: np.ndarray, *, labelled: bool = False) -> np.ndarray:
    """Say which readings of one specimen are of its first loading, (n,).

    Where it was pulled and pressed, either side has a first loading. Of loops that rise, those
    parts count that go farther than any before. What follows a fall of the load, as at a slip or a
    break, does not count. A table that is sorted from the farthest reading on, or that has no
    order, is taken as a whole.

    Args:
        stretch: (n,) stretches in the order of the rows.
        stress: (n,) nominal stresses.
        labelled: a column tells which readings are of the loading; slips and breaks alone are
            sought.
    """
    keep = np.ones(len(stretch), dtype=bool)
    for side, sign in ((stretch >= 1, 1.0), (stretch < 1, -1.0)):
        on_side = np.flatnonzero(side)
        way = sign * (stretch[on_side] - 1)
        if not len(on_side) or not (labelled or _in_order(way)):
            continue
        parts = [on_side] if labelled else [on_side[part] for part in _onwards(way)]
        load = sign * stress[np.concatenate(parts)]
        noise = max(TURN * float(load.max()), _noise(load))
        keep[on_side] = False
        for part in parts:
            keep[part] = _unbroken(sign * stress[part], noise)
            if not keep[part].all():
                break
    return keep


def _noise(values: np.ndarray) -> float:
    """Distance within which noise stays; 0 where values rise and fall for longer."""
    return NOISES * float(np.median(np.abs(values - median_filter(values, 3, mode="nearest"))))


def _in_order(way: np.ndarray) -> bool:
    """Say if a table begins near the state at rest, and has an order at all."""
    rises = float((way - np.minimum.accumulate(way)).max())
    return rises > TURN * float(way.max()) and _noise(way) < UNORDERED * float(way.max())


def _onwards(way: np.ndarray) -> list[np.ndarray]:
    """Readings that go farther than all before the last turn: those of each loop, in its order."""
    back = max(TURN * float(way.max()), _noise(way))
    parts: list[list[int]] = [[]]
    farthest = before = -np.inf
    beyond = 0.0
    pending: list[int] = []
    for i, distance in enumerate(way):
        if distance > farthest + beyond:
            parts[-1] += [*pending, i]
            farthest, beyond, pending = distance, 0.0, []
        elif distance < farthest - back:  # noise alone takes the tip of a later loop as far as this
            before, beyond, pending = farthest, back, []
            parts.append([])
        elif distance > before:  # noise, unless the way back begins here
            pending.append(i)
    return [np.array(part, dtype=int) for part in parts if part]


def _unbroken(load: np.ndarray, noise: float) -> np.ndarray:
    """Which readings come before a fall of the load; one that falls alone is a fault of its own."""
    smooth = median_filter(load, 3, mode="nearest")
    least = (1 - FALL) * np.maximum.accumulate(smooth) - noise
    keep, fallen = load >= least, smooth < least
    if fallen.any():
        keep[int(np.argmax(load[: int(np.argmax(fallen)) + 1])) + 1 :] = False
    return keep


def is_hollow(strain: np.ndarray, load: np.ndarray) -> bool:
    """Say if the tangent rises from the start, as in no tension of rubber but in its compression.

    Args:
        strain: (n,) nominal strains of a loading; nothing is pressed by 1.
        load: (n,) forces or nominal stresses.
    """
    ends = strain.min() + np.ptp(strain) * np.linspace(0, 1, 5)
    parts = [(low <= strain) & (strain <= high) for low, high in pairwise(ends)]
    if strain.max(initial=0) > FLAT or min(len(set(strain[part])) for part in parts) < 2:
        return False
    slopes = np.array([np.polyfit(strain[part], load[part], 1)[0] for part in parts])
    return bool(slopes[0] > 0 and (np.diff(slopes) > 0).all() and slopes[3] > STEEPER * slopes[0])


def slack_strain(stretch: np.ndarray, stress: np.ndarray) -> float:
    """Return the strain up to which a coupon is slack, as its load then rises at once; else 0.

    Args:
        stretch: (n,) stretches of its first loading.
        stress: (n,) nominal stresses.
    """
    strain, load = np.abs(stretch - 1), np.abs(median_filter(stress, 3, mode="nearest"))
    idle = NEXT_TO_NOTHING * load.max()
    taut = float(strain[load <= idle].max(initial=0))
    behind = load[(1.5 * taut <= strain) & (strain <= 2 * taut)]
    rises = len(behind) and np.median(behind) > 3 * idle
    return taut if rises and taut > SLACK * strain.max() else 0.0


def pressed(values: np.ndarray) -> np.ndarray:
    """Travels or loads of a press with the sign that they have in compression.

    Args:
        values: (n,) from their zero on; of either sign.
    """
    moved = values - values[np.isfinite(values)][0]
    return values if moved[np.nanargmax(np.abs(moved))] < 0 else -values

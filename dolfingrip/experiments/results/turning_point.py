"""The turning point of the blocked-force curve, where bellows touch and the curve steepens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dolfingrip.files.run import TurningPoint

STEEPER = 1.1
"""Smallest ratio of the slopes after and before a turning point."""


def find(
    pressure_kPa: npt.ArrayLike,
    force_N: npt.ArrayLike,
    gaps_mm: Sequence[dict[str, float]] = (),
    touch_mm: float = 0.0,
) -> TurningPoint | None:
    """Fit two lines that meet by least squares; they may meet anywhere between readings.

    Args:
        pressure_kPa: (n,) increasing pressures of the loading branch.
        force_N: (n,) forces there.
        gaps_mm: for each reading, the distance of each pair of neighbouring bellows.
        touch_mm: distance at which a pair touches.

    Returns:
        The turning point; None with fewer than five readings, or if no slope rises enough.
    """
    p, f = np.asarray(pressure_kPa, dtype=float), np.asarray(force_N, dtype=float)
    if len(p) < 5:
        return None
    breaks = np.linspace(p[1], p[-2], 20 * len(p))

    def fit(at: float) -> tuple[float, np.ndarray]:
        basis = np.stack([np.ones_like(p), p - at, np.maximum(p - at, 0)], axis=1)
        solution = np.linalg.lstsq(basis, f)[0]
        return float(np.sum((basis @ solution - f) ** 2)), solution

    at = min(breaks, key=lambda b: fit(b)[0])
    level, before, change = fit(at)[1]
    if before <= 0 or before + change < STEEPER * before:
        return None
    touch, pair = _first_touch(p, gaps_mm, touch_mm)
    return TurningPoint(float(at), float(level), float(before), float(before + change), touch, pair)


def _first_touch(
    p: np.ndarray, gaps_mm: Sequence[dict[str, float]], touch_mm: float
) -> tuple[float | None, str | None]:
    """Pressure and pair of the first touch.

    The gap closes freely until the barrier holds it open. The line through the two readings before
    the touch is therefore extrapolated, if there are two. Interpolation to the reading after the
    touch would give too high a pressure.
    """
    first: tuple[float | None, str | None] = (None, None)
    for pair in gaps_mm[0] if gaps_mm else ():
        gaps = np.array([gap[pair] for gap in gaps_mm])
        closed = np.flatnonzero(gaps <= touch_mm)
        if not closed.size:
            continue
        i = int(closed[0])
        at = float(p[i])
        start = i - 2 if i > 1 and gaps[i - 1] < gaps[i - 2] < np.inf else i - 1
        if i and np.isfinite(gaps[i - 1]):
            rate = (gaps[start + 1] - gaps[start]) / (p[start + 1] - p[start])
            at = float(np.clip(p[i - 1] + (touch_mm - gaps[i - 1]) / rate, p[i - 1], p[i]))
        if first[0] is None or at < first[0]:
            first = (at, pair)
    return first

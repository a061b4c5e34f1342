"""The blocked-force curve's turning point: where touching bellows steepen it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

STEEPER = 1.1
"""Smallest ratio of the slopes that counts as a turn."""


@dataclass(frozen=True, slots=True)
class TurningPoint:
    """Meeting point of the two straight lines that fit the curve best.

    Attributes:
        pressure_kPa: where the lines meet.
        force_N: where the lines meet.
        slope_before_N_per_kPa: of the first line.
        slope_after_N_per_kPa: of the second line.
        touch_kPa: pressure at which the first bellows touch; None where none do.
        touching: names of the first bellows to touch; None where none do.
    """

    pressure_kPa: float
    force_N: float
    slope_before_N_per_kPa: float
    slope_after_N_per_kPa: float
    touch_kPa: float | None = None
    touching: str | None = None

    def sentence(self) -> str:
        """What was found, with units."""
        text = (
            f"turning point at {self.pressure_kPa:.0f} kPa, {self.force_N:.2f} N: slope "
            f"{self.slope_before_N_per_kPa:.4f} N/kPa before, "
            f"{self.slope_after_N_per_kPa:.4f} N/kPa after"
        )
        if self.touch_kPa is not None:
            text += f"; first to touch: {self.touching}, at {self.touch_kPa:.0f} kPa"
        return text


def find(
    pressure_kPa: npt.ArrayLike,
    force_N: npt.ArrayLike,
    gaps_mm: Sequence[dict[str, float]] = (),
    touch_mm: float = 0.0,
) -> TurningPoint | None:
    """Fit a continuous pair of lines by least squares, the break free between readings.

    Args:
        pressure_kPa: (n,) loading branch, increasing.
        force_N: (n,) readings.
        gaps_mm: for each reading the distance by pair of neighbours.
        touch_mm: distance at which a pair counts as touching.

    Returns:
        None with fewer than five readings or where the curve does not turn upwards.
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

    The gap closes freely until the barrier holds it open, so the line through the two readings
    before the touch is extrapolated, where there are two. Interpolation to the reading after the
    touch would place it too late.
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

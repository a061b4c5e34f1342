"""Causes that no catalogue has: they live in the generator alone.

Most act on the pressure or on what instruments display; two are another geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.config import Change, Config

Rows = pd.DataFrame
"""``pressure_kPa`` of a test, in the order of time."""
Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True, slots=True)
class Outsider:
    """A cause outside the catalogue; what it does not do is None.

    Attributes:
        pressure: from a test's rows and a strength to the pressure that is there (kPa) where the
            gauge shows that of the rows.
        displayed: from rows, true readings and strength to those that are displayed otherwise.
        overrides: from the configuration and a strength to another geometry.
    """

    pressure: Callable[[Rows, float], np.ndarray] | None = None
    displayed: Callable[[Rows, Columns, float], Columns] | None = None
    overrides: Callable[[Config, float], Change] | None = None


def _backlash(rows: Rows, strength: float) -> np.ndarray:
    """The gauge sticks: the pressure is 1.6 % further than it shows, the way that it moves."""
    shown = rows["pressure_kPa"].to_numpy()
    way = np.sign(np.diff(shown, prepend=0.0))
    for i in range(1, len(way)):
        way[i] = way[i] or way[i - 1]
    part = shown / shown.max()
    return np.asarray(shown + 0.016 * strength * shown.max() * way * np.clip(10 * part, 0.0, 1.0))


def _leak(rows: Rows, strength: float) -> np.ndarray:
    """A crack beyond the gauge, which opens: 6 % less at the end, as the square of the pressure."""
    shown = rows["pressure_kPa"].to_numpy()
    return np.asarray(shown * (1 - 0.06 * strength * (shown / shown.max()) ** 2))


def _perspective(rows: Rows, true: Columns, strength: float) -> Columns:
    """A camera close to the finger: angles are too large, by 5 % at the largest."""
    if "angle_deg" not in true:
        return {}
    angle = true["angle_deg"]
    return {"angle_deg": angle * (1 + 0.05 * strength * angle / np.abs(angle).max())}


def _soft_foam(rows: Rows, true: Columns, strength: float) -> Columns:
    """A foam on the plate takes up a part of small forces: F²/(F + 0.05 N)."""
    if "force_N" not in true:
        return {}
    force = np.maximum(true["force_N"], 0.0)
    return {"force_N": force**2 / (force + 0.05 * strength)}


def _slip(rows: Rows, true: Columns, strength: float) -> Columns:
    """The clamp slips once, when 60 % are first passed: by 2°, off the plate by 0.05 N."""
    pressure = rows["pressure_kPa"].to_numpy()
    passed = np.maximum.accumulate(pressure) > 0.55 * pressure.max()
    if "force_N" in true:
        less = np.maximum(true["force_N"] - 0.05 * strength, 0.0)
        return {"force_N": np.where(passed, less, true["force_N"])}
    return {"angle_deg": true["angle_deg"] - 2.0 * strength * passed}


def _deep_clamp(config: Config, strength: float) -> Change:
    """The clamp holds 2 mm more of the base block."""
    finger, by_mm = config.finger, 2.0 * strength
    return {
        "finger.length_mm": finger.length_mm - by_mm,
        "finger.base_block_mm": finger.base_block_mm - by_mm,
    }


def _narrow_channel(config: Config, strength: float) -> Change:
    """The air channel is 0.5 mm lower than drawn, as its roof sagged in printing."""
    return {"finger.channel_mm": config.finger.channel_mm - 0.5 * strength}


OUTSIDERS: Final[Mapping[str, Outsider]] = {
    "backlash": Outsider(pressure=_backlash),
    "opening_leak": Outsider(pressure=_leak),
    "perspective": Outsider(displayed=_perspective),
    "soft_foam": Outsider(displayed=_soft_foam),
    "slip": Outsider(displayed=_slip),
    "deep_clamp": Outsider(overrides=_deep_clamp),
    "narrow_channel": Outsider(overrides=_narrow_channel),
}

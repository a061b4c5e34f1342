"""Causes that no catalogue has: they live in the generator alone.

Most act on the pressure or on what instruments display, one on the modulus; two are another
geometry, and are simulated. Sizes are by an ordinary one, drawn from a log-normal of mean 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from benchmarks.blind.protocols import Protocol

Rows = pd.DataFrame
Columns = Mapping[str, np.ndarray]

SPREAD: Final = 0.5
"""Of the logarithm of the size."""


@dataclass(frozen=True, slots=True)
class Outsider:
    """A cause outside the catalogue; what it does not do is None.

    Attributes:
        name: of it.
        what: it is, in words.
        pressure: from a test's rows and a size to the pressure that is there (kPa) where the
            gauge shows that of the rows.
        modulus: from rows and size to the factor of all moduli.
        displayed: from rows, true readings and size to the displayed ones.
        overrides: from a size to the generator's configuration; it then is simulated.
    """

    name: str
    what: str
    pressure: Callable[[Rows, float], np.ndarray] | None = None
    modulus: Callable[[Rows, float], np.ndarray] | None = None
    displayed: Callable[[Rows, Columns, float], Columns] | None = None
    overrides: Callable[[float], tuple[str, ...]] | None = None

    def draw(self, rng: np.random.Generator) -> float:
        """A size; within what is simulated."""
        return float(np.clip(rng.lognormal(-(SPREAD**2) / 2, SPREAD), 0.3, PARTS[-1] * 1.1))


PARTS: Final = (1.0, 2.0)
"""Sizes at which a geometry is simulated."""


def _backlash(rows: Rows, size: float) -> np.ndarray:
    """The gauge sticks: the pressure is 4 kPa further than it shows, the way that it moves."""
    shown = rows["pressure_kPa"].to_numpy()
    way = np.sign(np.diff(shown, prepend=0.0))
    for i in range(1, len(way)):
        way[i] = way[i] or way[i - 1]
    return shown + 4.0 * size * way * np.clip(shown / 25.0, 0.0, 1.0)


def _leak(rows: Rows, size: float) -> np.ndarray:
    """A crack beyond the gauge, which opens: 6 % less at 250 kPa, as the square of the pressure."""
    shown = rows["pressure_kPa"].to_numpy()
    return shown * (1 - 0.06 * size * np.maximum(shown / 250.0, 0.0) ** 2)


def _wear(rows: Rows, size: float) -> np.ndarray:
    """A seam that tears a little further in each cycle: 4 % softer."""
    return 1 - 0.04 * np.minimum(size * (rows["cycle"].to_numpy() - 1), 10.0)


def _perspective(rows: Rows, true: Columns, size: float) -> Columns:
    """A camera close to the finger: angles are too large by 5 % of their square by 100°."""
    return {
        name: true[name] * (1 + 0.05 * size * true[name] / 100.0)
        for name in ("angle_deg", "chord_angle_deg")
        if name in true
    }


def _soft_foam(rows: Rows, true: Columns, size: float) -> Columns:
    """A foam on the plate takes up a part of small forces: F²/(F + 0.05 N)."""
    if "force_N" not in true or "displacement_mm" in rows:
        return {}
    force = np.maximum(true["force_N"], 0.0)
    return {"force_N": force**2 / (force + 0.05 * size)}


def _slip(rows: Rows, true: Columns, size: float) -> Columns:
    """The clamp slips once, when 140 kPa are first passed, by 2°; the tip comes off the plate."""
    if "displacement_mm" in rows:
        return {}
    passed = np.maximum.accumulate(rows["pressure_kPa"].to_numpy()) > 140.0
    found = {}
    if "force_N" in true:
        found["force_N"] = np.where(
            passed, np.maximum(true["force_N"] - 0.05 * size, 0), true["force_N"]
        )
    elif "angle_deg" in true:
        found["angle_deg"] = true["angle_deg"] - 2.0 * size * passed
    return found


def _jaw_slip(rows: Rows, true: Columns, size: float) -> Columns:
    """A coupon slips in its jaws once, at 60 % of the travel: 6 % of the force are lost."""
    if "displacement_mm" not in rows:
        return {}
    travel = rows["displacement_mm"].to_numpy()
    passed = np.maximum.accumulate(travel) > 0.6 * travel.max()
    return {"force_N": true["force_N"] * (1 - 0.06 * min(size, 5.0) * passed)}


def _sticky_cell(rows: Rows, true: Columns, size: float) -> Columns:
    """A load cell that sticks: it lags by 0.1 N the way that the coupon moves."""
    if "displacement_mm" not in rows:
        return {}
    way = np.sign(np.diff(rows["displacement_mm"].to_numpy(), prepend=0.0))
    return {"force_N": true["force_N"] - 0.1 * size * way}


def _twisted_coupon(rows: Rows, true: Columns, size: float) -> Columns:
    """A coupon that is clamped twisted, and straightens: 0.15 N more in the midst of its travel."""
    if "displacement_mm" not in rows:
        return {}
    part = rows["displacement_mm"].to_numpy() / rows["displacement_mm"].max()
    return {"force_N": true["force_N"] + 0.15 * size * np.exp(-(((part - 0.5) / 0.1) ** 2))}


def _deep_clamp(size: float) -> tuple[str, ...]:
    """The clamp holds 2 mm more of the base block."""
    return (
        f"finger.length_mm={90 - 2.0 * size!r}",
        f"finger.base_block_mm={12 - 2.0 * size!r}",
    )


def _narrow_channel(size: float) -> tuple[str, ...]:
    """The air channel is 0.5 mm lower than drawn, as its roof sagged in printing."""
    return (f"finger.channel_mm={2.5 - 0.5 * size!r}",)


OUTSIDERS: Final[Mapping[str, Outsider]] = {
    each.name: each
    for each in (
        Outsider("backlash", "a gauge that sticks", pressure=_backlash),
        Outsider("opening_leak", "a leak that opens with pressure", pressure=_leak),
        Outsider("tear", "a seam that tears with each cycle", modulus=_wear),
        Outsider("perspective", "a camera that sees in perspective", displayed=_perspective),
        Outsider("soft_foam", "a foam on the plate", displayed=_soft_foam),
        Outsider("slip", "a clamp that slips once", displayed=_slip),
        Outsider("jaw_slip", "a coupon that slips in its jaws", displayed=_jaw_slip),
        Outsider("sticky_cell", "a load cell that sticks", displayed=_sticky_cell),
        Outsider("twisted_coupon", "a coupon that straightens", displayed=_twisted_coupon),
        Outsider("deep_clamp", "a clamp that holds more of the finger", overrides=_deep_clamp),
        Outsider("narrow_channel", "a channel that sagged", overrides=_narrow_channel),
    )
}


OF_COUPONS: Final = ("jaw_slip", "sticky_cell", "twisted_coupon")
"""That a coupon alone can feel."""


def possible(protocol: Protocol, name: str) -> bool:
    """Whether an outsider can be felt in a protocol."""
    if name == "tear":
        return any(course.rows["cycle"].max() > 1 for course in protocol.courses)
    if name in OF_COUPONS:
        return any(course.experiment == "coupon" for course in protocol.courses)
    if all(course.experiment == "coupon" for course in protocol.courses):
        return False
    outsider = OUTSIDERS[name]
    return protocol.body == "reference" or (outsider.overrides is None and name != "slip")

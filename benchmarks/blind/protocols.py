"""What is measured, row by row: protocols that each begin like the next longer one.

=== ======================================================================================
P1  free bending and blocked force, 11 pressures, first loading
P2  and unloading
P3  and two more cycles, the last one ten times as slow
P4  and a fourth loading with a wait of 60 s
P7+ and the tip's displacement, the angle while blocked, and a coupon up and down
=== ======================================================================================

Since a longer protocol goes on where a shorter one ends, one simulation serves several.
``short-P1``, ``short`` (like P2), ``short-P4``, ``short-P7+``, ``short-P7`` (without more cycles)
and ``coupon`` are cheap ones: a finger of two bellows, and a coupon alone. ``pull-up`` is the
coupon's first loading: many laws agree in it, which other rates, holds and cycles tell apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip.diagnosis.data.lab_setup import NUISANCES

FAST_kPa_per_s: Final = 25.0
SLOW_kPa_per_s: Final = 2.5
WAIT_S: Final = (2.0, 6.0, 20.0, 40.0, 60.0)
"""Readings of the wait."""
COUPON_mm: Final = 16.5
COUPON_mm_per_s: Final = 0.55
COUPON: Final = {"gauge_length_mm": 33.0, "area_mm2": 9.0}
SHARP: Final = {"coupon_slack_mm": 0.0, "material_law": 0.0}
"""What the generator's coupons do not have, which the laboratory tells."""


TOLD_AS: Final = {"pressure_offset": "pressure_offset_kPa", "plate_gap": "plate_gap_mm"}
"""Keys of nuisances in the laboratory's TOML, where the generator has another name."""


@dataclass(frozen=True, slots=True)
class Course:
    """The rows of one test, in order.

    Attributes:
        experiment: its name.
        rows: ``cycle``, ``branch``, ``time_s`` and ``pressure_kPa`` or ``displacement_mm``.
    """

    experiment: str
    rows: pd.DataFrame

    @property
    def control(self) -> str:
        """Column of the control."""
        return "displacement_mm" if self.experiment == "coupon" else "pressure_kPa"

    def protocol(self) -> dict[str, list[Any]]:
        """The table ``[protocol]`` of the configuration."""
        return {
            name: self.rows[name].tolist() for name in ("time_s", self.control, "cycle", "branch")
        }


@dataclass(frozen=True, slots=True)
class Protocol:
    """A protocol.

    Attributes:
        name: of it.
        courses: of its tests.
        columns: that are read, by experiment.
        history: name of the longest protocol of the same simulation.
        finger: overrides that make the finger another than the reference.
        gap_mm: of the plate as the laboratory tells it.
        known_better: part of the usual uncertainty of a nuisance that the laboratory has.
    """

    name: str
    courses: tuple[Course, ...]
    columns: Mapping[str, tuple[str, ...]]
    history: str
    finger: tuple[str, ...] = ()
    gap_mm: float = 1.0
    known_better: Mapping[str, float] = field(default_factory=dict)

    @property
    def body(self) -> str:
        """Which finger it is."""
        return "short" if self.finger else "reference"

    def setup(self) -> dict[str, Any]:
        """What the laboratory tells of its set-up, as in the TOML."""
        names = [course.experiment for course in self.courses]
        told: dict[str, Any] = {"experiment": names}
        if "coupon" in names:
            told |= COUPON
            told["nuisance"] = dict(SHARP)
        if "blocked_force" in names:
            told["plate"] = {"gap_mm": self.gap_mm}
        if self.known_better:
            stds = told.setdefault("nuisance", {})
            for name, part in self.known_better.items():
                key = TOLD_AS[name]
                stds[key] = round(part * NUISANCES[key][0], 6)
        return told

    def course(self, experiment: str) -> Course:
        """The one of an experiment."""
        return next(each for each in self.courses if each.experiment == experiment)


def ramp(
    start: float, end: float, step: float, rate: float, from_s: float, cycle: int, control: str
) -> list[dict[str, Any]]:
    """Rows after ``start`` up or down to ``end``, in equal steps."""
    count = round(abs(end - start) / step)
    branch = "loading" if end > start else "unloading"
    return [
        {
            "cycle": cycle,
            "branch": branch,
            "time_s": from_s + abs(value - start) / rate,
            control: float(value),
        }
        for value in np.linspace(start, end, count + 1)[1:]
    ]


def finger_rows(high_kPa: float, step_kPa: float, parts: int) -> pd.DataFrame:
    """Rows of the first ``parts`` of loading, unloading, two more cycles, loading with a wait."""
    control = "pressure_kPa"
    rows: list[dict[str, Any]] = [{"cycle": 1, "branch": "loading", "time_s": 0.0, control: 0.0}]

    def go(end: float, step: float, rate: float, cycle: int) -> None:
        last = rows[-1]
        rows.extend(ramp(last[control], end, step, rate, last["time_s"], cycle, control))

    go(high_kPa, step_kPa, FAST_kPa_per_s, 1)
    if parts > 1:
        go(0.0, step_kPa, FAST_kPa_per_s, 1)
    if parts > 2:
        for cycle, rate in ((2, FAST_kPa_per_s), (3, SLOW_kPa_per_s)):
            go(high_kPa, 2 * step_kPa, rate, cycle)
            go(0.0, 2 * step_kPa, rate, cycle)
    if parts > 3:
        go(high_kPa, 2 * step_kPa, FAST_kPa_per_s, 4)
        since_s = rows[-1]["time_s"]
        rows += [
            {"cycle": 4, "branch": "hold", "time_s": since_s + wait_s, control: high_kPa}
            for wait_s in WAIT_S
        ]
    return pd.DataFrame(rows)


def coupon_rows(step_mm: float, cycles: int = 1) -> pd.DataFrame:
    """A coupon pulled to 50 % and back, once or more."""
    control = "displacement_mm"
    rows: list[dict[str, Any]] = [{"cycle": 1, "branch": "loading", "time_s": 0.0, control: 0.0}]
    for cycle in range(1, cycles + 1):
        for end in (COUPON_mm, 0.0):
            last = rows[-1]
            rows += ramp(
                last[control], end, step_mm, COUPON_mm_per_s, last["time_s"], cycle, control
            )
    return pd.DataFrame(rows)


def _fingers(
    name: str, history: str, rows: pd.DataFrame, more: Sequence[Course] = (), **others: Any
) -> Protocol:
    tests = [Course(experiment, rows) for experiment in ("bending", "blocked_force")]
    columns = {"bending": ("angle_deg",), "blocked_force": ("force_N",), "coupon": ("force_N",)}
    return Protocol(name, (*tests, *more), others.pop("columns", columns), history, **others)


def _all() -> dict[str, Protocol]:
    tip = ("tip_x_mm", "tip_z_mm")
    every = {
        "bending": ("angle_deg", *tip),
        "blocked_force": ("force_N", "angle_deg", *tip),
        "coupon": ("force_N",),
    }
    coupon = Course("coupon", coupon_rows(1.65))
    twice = coupon_rows(COUPON_mm / 20, 2)
    first = twice[(twice["cycle"] == 1) & (twice["branch"] == "loading")]
    small: dict[str, Any] = {"finger": SHORT, "gap_mm": 0.1, "known_better": FINE}
    longest = finger_rows(50.0, 5.0, 4)
    found = [
        _fingers("P1", "P2", finger_rows(250.0, 25.0, 1)),
        _fingers("P2", "P2", finger_rows(250.0, 25.0, 2)),
        _fingers("P3", "P4", finger_rows(250.0, 25.0, 3)),
        _fingers("P4", "P4", finger_rows(250.0, 25.0, 4)),
        _fingers("P7+", "P4", finger_rows(250.0, 25.0, 4), [coupon], columns=every),
        _fingers("short-P1", "short", finger_rows(50.0, 5.0, 1), **small),
        _fingers("short", "short", finger_rows(50.0, 5.0, 2), **small),
        _fingers("short-P7", "short", finger_rows(50.0, 5.0, 2), [coupon], columns=every, **small),
        _fingers("short-P4", "short-P4", longest, **small),
        _fingers("short-P7+", "short-P4", longest, [coupon], columns=every, **small),
        Protocol("coupon", (Course("coupon", twice),), {"coupon": ("force_N",)}, "coupon"),
        Protocol("pull-up", (Course("coupon", first),), {"coupon": ("force_N",)}, "coupon"),
        Protocol("pull", (coupon,), {"coupon": ("force_N",)}, "pull"),
    ]  # fmt: skip
    return {each.name: each for each in found}


FINE: Final = {"pressure_offset": 0.1, "plate_gap": 0.1}
"""Of a finger that has a fifth of the pressure and a tenth of the gap."""
SHORT: Final = (
    "mesh.size_mm=6",
    "mesh.edge_size_mm=4",
    "finger.length_mm=38",
    "finger.bellows=2",
)
"""Two bellows, coarsely meshed by the analyser."""

PROTOCOLS: Final = _all()
PULL: Final = "pull"
"""The coupon's part of P7+."""
FINGERS: Final = ("P1", "P2", "P3", "P4", "P7+")
WITH_COUPON: Final = ("P7+", "short-P7", "short-P7+")
"""Protocols of fingers that also pull a coupon."""

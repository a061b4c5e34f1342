"""The columns of the measured-data format: what each experiment is controlled by and reads."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from typing import Final

from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.recorder import COLUMNS

EXPERIMENT_NAMES: Final = tuple(name for name, each in EXPERIMENTS.items() if each.measured)
"""Experiments that the format has and the package simulates."""

NOT_SIMULATED: Final = ("grasp", "pick_up")
"""Experiments that the format has and the package does not simulate."""

WHO: Final = ("experiment", "specimen", "cycle", "branch")
"""Columns that say what a row belongs to."""

CONTROL: Final[Mapping[str, str]] = {name: EXPERIMENTS[name].control for name in EXPERIMENT_NAMES}
"""Column of what each experiment is controlled by."""

READINGS: Final[Mapping[str, tuple[str, ...]]] = {
    "bending": ("angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm"),
    "blocked_force": ("force_N", "angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm"),
    "coupon": ("force_N", "transverse_strain"),
}
"""Columns that each experiment reads; any of them may be absent."""

READING_COLUMNS: Final = (
    "angle_deg", "chord_angle_deg", "force_N", "tip_x_mm", "tip_z_mm", "transverse_strain",
)  # fmt: skip
"""All columns of readings."""

NUMBERS: Final = ("time_s", "pressure_kPa", "displacement_mm", *READING_COLUMNS)
"""All columns of numbers."""

MEASURED: Final = (*WHO, *NUMBERS)
"""All columns of the format."""

IGNORED: Final = frozenset(
    {*COLUMNS, *(name for each in EXPERIMENTS.values() for name in each.columns)} - {*MEASURED}
)
"""What a simulation's ``result.csv`` has besides, which no instrument reads."""

RATIOS: Final = ("transverse_strain",)
"""Columns of pure numbers; others end in their unit."""

LOWEST_PRESSURE_kPa: Final = -10.0
"""A gauge that is off by its zero shows no less (three standard deviations of its offset)."""

RANGES: Final[Mapping[str, tuple[float, float]]] = {
    "time_s": (0.0, 1e9),
    "pressure_kPa": (LOWEST_PRESSURE_kPa, 1e4),
    "displacement_mm": (-1e3, 1e4),
    "angle_deg": (-720.0, 720.0),
    "chord_angle_deg": (-720.0, 720.0),
    "force_N": (-1e5, 1e5),
    "tip_x_mm": (-1e3, 1e3),
    "tip_z_mm": (-1e3, 1e3),
    "transverse_strain": (-1.0, 1.0),
}
"""Values that are no slip of the pen, by column, in its unit."""


def near(name: str, known: Sequence[str]) -> str:
    """``did you mean …? ``, where a known name is like ``name``; else nothing."""
    found = difflib.get_close_matches(name, known, 1, 0.6)
    return f"did you mean {found[0]}? " if found else ""

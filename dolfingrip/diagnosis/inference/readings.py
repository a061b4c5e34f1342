"""What was read: a value for each reading, and a table that tells what each reading is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from dolfingrip.diagnosis.inference.arrays import Vector

COLUMNS = (
    "channel", "run", "experiment", "specimen", "cycle", "branch", "time_s", "pressure_kPa",
)  # fmt: skip
"""Columns that the table of readings must have. ``run`` is one uninterrupted measurement of one
specimen, the same for all channels that were read during it."""

OPTIONAL = ("rate_kPa_per_s", "displacement_mm", "design")
"""``design`` is alike where specimens are drawn alike, so that they repeat one another."""


@dataclass(frozen=True)
class Readings:
    """All readings of all experiments, one row each.

    Attributes:
        index: columns :data:`COLUMNS`, and those of :data:`OPTIONAL` that are known; n rows.
        value: shape (n,), each in the unit of its channel.
    """

    index: pd.DataFrame
    value: Vector

    def __post_init__(self) -> None:
        """Check the table.

        Raises:
            ValueError: one line naming a missing column, a wrong length or a reading without value.
        """
        missing = [name for name in COLUMNS if name not in self.index.columns]
        if missing:
            raise ValueError(f"table of readings has no column {missing[0]}")
        if self.value.shape != (len(self.index),):
            raise ValueError(f"{len(self.index)} rows, but values of shape {self.value.shape}")
        if not np.isfinite(self.value).all():
            row = int(np.flatnonzero(~np.isfinite(self.value))[0])
            raise ValueError(f"reading {row} ({self.index['channel'].iloc[row]}) has no value")

    def __len__(self) -> int:
        return len(self.index)


def tracks(index: pd.DataFrame) -> list[npt.NDArray[np.intp]]:
    """Rows of each channel of each run, in the order of time.

    Noise that is correlated is so along these; between them it is independent.
    """
    numbers = index.reset_index(drop=True)
    return [
        rows["time_s"].sort_values(kind="stable").index.to_numpy()
        for _, rows in numbers.groupby(["run", "channel"], sort=False)
    ]


def load(index: pd.DataFrame) -> Vector:
    """How far each reading is loaded: pressure as a part of its experiment's largest, shape (n,).

    Where an experiment has no pressure, the displacement takes its place; where neither is known,
    the place in the run does.
    """
    result = np.zeros(len(index))
    numbers = index.reset_index(drop=True)
    for _, rows in numbers.groupby("experiment", sort=False):
        values = _driving(rows)
        result[rows.index] = values / max(float(np.abs(values).max()), 1e-12)
    return result


def _driving(rows: pd.DataFrame) -> Vector:
    for name in ("pressure_kPa", "displacement_mm"):
        if name in rows.columns:
            values = rows[name].to_numpy(dtype=float)
            if np.isfinite(values).all() and np.ptp(values) > 0:
                return values
    return rows.groupby(["run", "channel"]).cumcount().to_numpy(dtype=float)

"""The table that tells what each reading is: a row for each.

Its columns are ``channel``, ``run``, ``experiment``, ``specimen``, ``cycle``, ``branch``,
``time_s`` and ``pressure_kPa``; ``rate_kPa_per_s``, ``displacement_mm`` and ``design`` where they
are known. ``run`` is one uninterrupted measurement of one specimen, the same for all channels that
were read during it. ``design`` is alike where specimens are drawn alike, so that they repeat one
another.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd

from dolfingrip.diagnosis.inference.arrays import Vector


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

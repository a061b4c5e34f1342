"""Which readings are compared: coupons between toe and the largest strain, and not too many."""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.data.measurement import Measurement

TOE: Final = 0.02
"""Nominal strain below which grips and slack are measured, too (ASTM D638, annex on the toe)."""

FEWEST: Final = 5
"""Readings of a coupon that are left at least, or none is left out."""

MOST: Final = 1200
"""Readings in all; of more, every second, third, … row of each branch is taken."""


def selected(measurement: Measurement, config: Config) -> tuple[Measurement, list[str]]:
    """The measurement without the rows that are not compared, and why, a sentence each."""
    keep = np.ones(len(measurement.readings), dtype=bool)
    readings = measurement.readings.copy()
    notes: list[str] = []
    for test in measurement.tests:
        if test.experiment != "coupon":
            continue
        coupon = test.setup.applied(config).coupon
        rows = measurement.rows(test.number)
        strain = rows["displacement_mm"].to_numpy() / coupon.gauge_length_mm
        for inside, why in (
            (strain <= coupon.max_strain, f"above a strain of {coupon.max_strain:g} "
             "(coupon.max_strain: fingers stretch less)"),
            (strain >= TOE, f"below a strain of {TOE:g} (grips settle there)"),
        ):  # fmt: skip
            if not inside.all() and inside.sum() >= FEWEST:
                # the row stays, as what comes later depends on the way
                readings.loc[rows.index[~inside], list(READING_COLUMNS)] = np.nan
                notes.append(f"coupons: readings {why} are left out")
    every = -(-len(readings) // MOST)
    if every > 1:
        number = measurement.readings.groupby(["test", "cycle", "branch"]).cumcount().to_numpy()
        keep &= number % every == 0
        notes.append(f"of dense readings one in {every} is compared")
    if not notes:
        return measurement, []
    readings = readings[keep].reset_index(drop=True)
    return Measurement(readings, measurement.tests, measurement.warnings), list(
        dict.fromkeys(notes)
    )

"""Which readings are compared: coupons between toe and the largest strain, and not too many.

Of a finger those up to the pressure that the laboratory tells, if any.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import DATA


def selected(measurement: Measurement, config: Config) -> tuple[Measurement, list[str]]:
    """The measurement without the rows that are not compared, and why, a sentence each.

    Raises:
        ConfigError: one line, where nothing of a finger's readings would be left.
    """
    repeated = measurement.repeated()
    notes = [
        f"{measurement.tests[again]} has the very readings of {measurement.tests[first]}: they are "
        "compared once"
        for again, first in repeated.items()
    ]
    if repeated:
        measurement = measurement.of({test.number for test in measurement.tests} - {*repeated})
    keep = np.ones(len(measurement.readings), dtype=bool)
    readings = measurement.readings.copy()
    for test in measurement.tests:
        rows = measurement.rows(test.number)
        finger = test.of_finger
        for inside, why in _of_finger(test, rows) if finger else _of_coupon(test, rows, config):
            if inside.all() or (not finger and inside.sum() < DATA.fewest_of_coupon):
                continue
            notes.append(why)
            readings.loc[rows.index[~inside], measurement.columns] = np.nan
            # a row stays where what comes later depends on the way
            if finger and not inside[(~inside).argmax() :].any():
                keep[rows.index[~inside]] = False
    every = math.ceil(len(readings) / DATA.most)
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


def _of_coupon(
    test: SpecimenTest, rows: pd.DataFrame, config: Config
) -> Iterator[tuple[np.ndarray, str]]:
    """Iterate over a coupon's rows that are compared, and why the others are left out."""
    coupon = test.setup.applied(config).coupon
    strain = rows["displacement_mm"].to_numpy() / coupon.gauge_length_mm
    most = f"above a strain of {coupon.max_strain:g} (coupon.max_strain: fingers stretch less)"
    yield strain <= coupon.max_strain, f"coupons: readings {most} are left out"
    toe = f"below a strain of {DATA.toe:g} (grips settle there)"
    yield strain >= DATA.toe, f"coupons: readings {toe} are left out"


def _of_finger(test: SpecimenTest, rows: pd.DataFrame) -> Iterator[tuple[np.ndarray, str]]:
    """Iterate over a finger's rows that are compared, and why the others are left out.

    Raises:
        ConfigError: no row is left.
    """
    highest = test.setup.max_pressure_kPa
    pressure_kPa = rows[list(test.controls)].max(axis=1).to_numpy()
    least = float(pressure_kPa.min())
    if highest < least:
        raise ConfigError(
            f"max_pressure_kPa = {highest:g} of {test.file.name}: below all readings of "
            f"{test.specimen}; allowed: from {least:g} kPa on"
        )
    limit = f"{highest:g} kPa (max_pressure_kPa of {test.file.name})"
    yield pressure_kPa <= highest, f"readings above {limit} are left out"

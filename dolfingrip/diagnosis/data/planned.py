"""Rows of tests that are not made yet: protocols with readings of 0."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from dolfingrip.channels import TIME
from dolfingrip.diagnosis.data.columns import NUMBERS
from dolfingrip.diagnosis.data.measurement import SpecimenTest
from dolfingrip.diagnosis.policy import DATA


def cycles(count: int, *, unload: bool = True) -> list[tuple[str, int]]:
    """Branch and cycle of so many ramps up; they also go down if there are several, or if asked."""
    branches = ["loading", "unloading"] if unload or count > 1 else ["loading"]
    return [(branch, cycle) for cycle in range(1, count + 1) for branch in branches]


def rows(
    test: SpecimenTest,
    way: Iterable[tuple[str, int]],
    ramp: Sequence[float] | np.ndarray,
    rate: float,
    columns: Sequence[str],
    *,
    hold_s: float = 60.0,
) -> pd.DataFrame:
    """Rows of a protocol, as in ``Measurement.readings``; the first is at rest.

    Args:
        test: test of the rows; its ``control`` column is prescribed.
        way: branches, each with the number of its cycle; a ``hold`` is at the highest value.
        ramp: (m,) rising values, above 0, at which loading is read.
        rate: rate of ramps, in the unit of ``ramp`` per second.
        columns: columns that are read.
        hold_s: duration of a wait.
    """
    values = np.asarray(ramp, dtype=float)
    found: list[dict[str, Any]] = []
    time_s, here = 0.0, 0.0
    for number, (branch, cycle) in enumerate(way):
        if branch == "hold":
            waits = hold_s * (np.arange(1, DATA.readings_of_wait + 1) / DATA.readings_of_wait) ** 2
            steps = [(here, time_s + wait) for wait in waits]
        else:
            up = values if number else np.append(0.0, values)
            steps = []
            for value in up if branch == "loading" else np.append(values[-2::-1], 0.0):
                time_s += abs(value - here) / rate
                here = float(value)
                steps.append((here, time_s))
        time_s = float(steps[-1][1])
        found += [
            {
                "line": 0, "test": test.number, "experiment": test.experiment,
                "specimen": test.specimen, "cycle": cycle, "branch": branch,
                **dict.fromkeys(NUMBERS, np.nan), TIME.name: moment, test.control: value,
                **dict.fromkeys(columns, 0.0),
            }
            for value, moment in steps
        ]  # fmt: skip
    return pd.DataFrame(found)

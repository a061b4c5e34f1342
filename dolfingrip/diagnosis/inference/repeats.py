"""Which readings repeat one another: the same place of the same protocol, on another specimen.

Specimens that are drawn in different ways do not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

TOLERANCE_KPA = 5.0
"""Pressures that differ by more are not the same place of a protocol."""


def places(
    index: pd.DataFrame,
    across: Sequence[str] = ("specimen",),
    tolerance_kPa: float = TOLERANCE_KPA,
) -> npt.NDArray[np.intp]:
    """A number for each reading, the same where readings repeat one another, shape (n,).

    Readings are counted within each branch of each cycle of a run; the k-th of one run repeats the
    k-th of another, if their pressures agree and both branches have as many readings.

    Args:
        index: table of the readings.
        across: what may differ between repeats, of ``specimen`` and ``cycle``. Cycles repeat one
            another only where nothing changes from cycle to cycle.
        tolerance_kPa: by which pressures may differ.

    Raises:
        ValueError: one line naming what cannot be repeated across.
    """
    for name in across:
        if name not in ("specimen", "cycle"):
            raise ValueError(f"repeats across {name}: allowed: specimen, cycle")
    table = index.reset_index(drop=True)
    table = table.sort_values("time_s", kind="stable")
    branch = table.groupby(["run", "channel", "cycle", "branch"], sort=False)
    table["place"] = branch.cumcount()
    table["count"] = branch["time_s"].transform("size")
    keys = ["channel", "experiment", "branch", "place", "count"]
    keys += [name for name in ("specimen", "cycle") if name not in across]
    keys += ["design"] if "design" in table else []
    same = table.groupby(keys, sort=False)
    number = same.ngroup()
    spread = same["pressure_kPa"].transform("max") - same["pressure_kPa"].transform("min")
    alone = (spread > tolerance_kPa).to_numpy()
    number = number.to_numpy().copy()
    number[alone] = number.max(initial=0) + 1 + np.arange(alone.sum())
    result = np.empty(len(index), dtype=int)
    result[table.index.to_numpy()] = number
    return result

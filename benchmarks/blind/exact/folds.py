"""What is left out in turn: bands, branches, cycles, rates, specimens, experiments."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.diagnosis.inference.readings import load

BANDS: Final = 5
FEWEST: Final = 2
"""Readings of a fold, and of what is left to fit."""


def folds(index: pd.DataFrame) -> dict[str, list[np.ndarray]]:
    """Readings that are left out together, shape (n,) of bool each, by what they are."""
    band = np.clip(np.ceil(load(index) * BANDS), 1, BANDS)
    labels = {
        "load bands": band,
        "branches": index["branch"].to_numpy(),
        "cycles": index["cycle"].to_numpy(),
        "rates": index["rate_kPa_per_s"].to_numpy(),
        "specimens": index["specimen"].to_numpy(),
        "experiments": index["experiment"].to_numpy(),
    }
    found = {}
    for name, values in labels.items():
        # a coupon is controlled by its travel and has no rate of the pressure
        parts = [values == label for label in pd.Series(values).dropna().unique()]
        parts = [p for p in parts if p.sum() >= FEWEST and (~p).sum() >= FEWEST]
        if len(parts) > 1:
            found[name] = parts
    return found

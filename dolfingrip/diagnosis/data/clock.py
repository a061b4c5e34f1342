"""Whether the times of a record tell how a body moved while its control rests."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.channels import TIME
from dolfingrip.config import Config, ConfigError

GAP: Final = 10
"""Longest step between two rows, by the usual one, that is no gap."""


def moves(config: Config) -> bool:
    """Tell whether a body goes on while the control rests: by inertia, or as its air flows.

    Args:
        config: with its set-up.
    """
    return config.experiment.dynamic or config.supply is not None


def gap(rows: pd.DataFrame, control: str, where: str) -> list[str]:
    """Say where a record of a body that moves has its longest gap.

    Args:
        rows: of one test, with their times.
        control: column of what the experiment controls.
        where: file and test, for the sentence.

    Raises:
        ConfigError: one line, where time stands still while the control does.
    """
    time_s, value = rows[TIME.name].to_numpy(), rows[control].to_numpy()
    steps, jumps = np.diff(time_s), np.diff(value)
    still = np.flatnonzero((steps == 0) & (jumps == 0))
    if still.size:
        first = int(still[0]) + 1
        raise ConfigError(
            f"{where}: line {rows['line'].iloc[first]}: time_s = {time_s[first]:g} again, and "
            f"{control} = {value[first]:g} again; allowed: times that rise, as the body moves"
        )
    within = steps[(steps > 0) & (rows["cycle"].diff().to_numpy()[1:] == 0)]
    if not within.size or within.max() <= GAP * np.median(within):
        return []
    at = int(np.argmax(steps == within.max()))
    return [
        f"{where}: no row from {time_s[at]:g} to {time_s[at + 1]:g} s, elsewhere one every "
        f"{np.median(within):.2g} s; {control} is taken to go straight across the gap"
    ]

"""Instruments' noise with a part that drifts, and readings that are missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd

from benchmarks.blind.protocols import Protocol
from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.inference.noise import ChannelNoise

SHARE: Final = 0.25
"""Of the variance, of the part that drifts along a run."""
LASTS_S: Final = 20.0
"""How long that part keeps."""
MISSING: Final = 0.06
"""Probability that a reading is missing."""


@dataclass(frozen=True, slots=True)
class Instruments:
    """How instruments scatter, as the laboratory tells.

    Attributes:
        factor: of all noise, by the ordinary one.
    """

    factor: float = 1.0

    def of(self, column: str) -> ChannelNoise:
        """Noise of a column that is there, in its unit."""
        total = self.factor * CHANNELS[column].noise
        return ChannelNoise(
            std=total * np.sqrt(1 - SHARE), correlated_std=total * np.sqrt(SHARE), length=LASTS_S
        )

    def told(self, columns: tuple[str, ...]) -> dict[str, Any]:
        """The table ``[noise]`` of the TOML."""
        noise = {name: self.of(name) for name in columns}
        correlated = {name: round(each.correlated_std, 6) for name, each in noise.items()}
        found: dict[str, Any] = {name: round(each.std, 6) for name, each in noise.items()}
        return {**found, "correlated": {**correlated, "correlation_time_s": LASTS_S}}


def channels(protocol: Protocol) -> tuple[str, ...]:
    """All columns that a protocol reads."""
    read = {name for columns in protocol.columns.values() for name in columns}
    return tuple(name for name in READING_COLUMNS if name in read)


def index(protocol: Protocol) -> pd.DataFrame:
    """Table of all single readings, as inference takes it, in the order of the vector."""
    rows = []
    for course in protocol.courses:
        names = [c for c in READING_COLUMNS if c in protocol.columns[course.experiment]]
        for row in course.rows.to_dict("records"):
            for name in names:
                rows.append({
                    "channel": name, "run": course.experiment, "experiment": course.experiment,
                    "specimen": "A", "cycle": row["cycle"], "branch": row["branch"],
                    "time_s": row["time_s"], "pressure_kPa": row.get("pressure_kPa", np.nan),
                    "displacement_mm": row.get("displacement_mm", np.nan),
                })  # fmt: skip
    return pd.DataFrame(rows)


def by_channel(protocol: Protocol, instruments: Instruments) -> Mapping[str, ChannelNoise]:
    """What is there, by column."""
    return {name: instruments.of(name) for name in channels(protocol)}


def draw(readings: pd.DataFrame, matrix: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n,) noise of all readings, of the covariance ``matrix``."""
    factor = np.linalg.cholesky(matrix)
    return np.asarray(factor @ rng.standard_normal(len(readings)))


def kept(readings: pd.DataFrame, rng: np.random.Generator) -> np.ndarray:
    """(n,) which readings are there; at least half of each channel of each run."""
    found = rng.random(len(readings)) >= MISSING
    for rows in readings.groupby(["run", "channel"], sort=False).indices.values():
        if found[rows].mean() < 0.5:
            found[rows] = True
    return found

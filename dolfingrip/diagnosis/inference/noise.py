"""Measurement noise: its size in each channel, and how it is correlated along a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pandas as pd

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.readings import tracks

Along = Literal["time_s", "row"]


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of one channel; standard deviations in the unit of the channel.

    Attributes:
        std: of the part that is independent from reading to reading.
        correlated_std: of the part that is correlated along a run, by exp(−distance/length)
            (Ornstein–Uhlenbeck).
        length: over which that part forgets, in the unit of ``along``.
        along: whether distance is time (s) or number of readings.
        offset_std: of an offset that a whole run shares.
        drift_std: of a drift at constant rate, at the end of a run.
    """

    std: float
    correlated_std: float = 0.0
    length: float = 1.0
    along: Along = "time_s"
    offset_std: float = 0.0
    drift_std: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: one line naming the number, its value and the allowed range.
        """
        for name in ("std", "length"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"noise {name} = {value}: allowed: above 0")
        for name in ("correlated_std", "offset_std", "drift_std"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"noise {name} = {value}: allowed: at least 0")

    def total_std(self) -> float:
        """Standard deviation of one reading, without offset and drift."""
        return float(np.hypot(self.std, self.correlated_std))

    def scaled(self, factor: float) -> ChannelNoise:
        """The same noise ``factor`` times as large."""
        return replace(
            self,
            std=factor * self.std,
            correlated_std=factor * self.correlated_std,
            offset_std=factor * self.offset_std,
            drift_std=factor * self.drift_std,
        )

    def with_correlated_part(
        self, share: float, length: float, along: Along = "time_s"
    ) -> ChannelNoise:
        """The same noise of one reading, of which ``share`` of the variance is correlated.

        Args:
            share: from 0 to below 1.
            length: of the correlation, in the unit of ``along``.
            along: see the class.
        """
        total = self.total_std()
        return replace(
            self,
            std=total * np.sqrt(1 - share),
            correlated_std=total * np.sqrt(share),
            length=length,
            along=along,
        )

    def of_track(self, time_s: Vector) -> Matrix:
        """Covariance of the readings of one run, at these times in ascending order, (m, m)."""
        count = len(time_s)
        place = time_s if self.along == "time_s" else np.arange(count, dtype=float)
        distance = np.abs(place[:, None] - place[None, :])
        matrix = self.correlated_std**2 * np.exp(-distance / self.length)
        matrix += self.offset_std**2
        if self.drift_std and count > 1:
            passed = (place - place[0]) / max(place[-1] - place[0], 1e-12)
            matrix += self.drift_std**2 * np.outer(passed, passed)
        matrix[np.diag_indices(count)] += self.std**2
        return np.asarray(matrix)


def noise_matrix(index: pd.DataFrame, noise: Mapping[str, ChannelNoise]) -> Matrix:
    """Covariance of the noise of all readings.

    Args:
        index: of the readings, n rows.
        noise: by channel.

    Returns:
        Shape (n, n), in the units of the channels.

    Raises:
        ValueError: one line naming a channel whose noise is not given.
    """
    matrix = np.zeros((len(index), len(index)))
    channels = index["channel"].to_numpy()
    times = index["time_s"].to_numpy(dtype=float)
    for rows in tracks(index):
        channel = channels[rows[0]]
        if channel not in noise:
            raise ValueError(f"noise of {channel} is not given; given: {', '.join(noise)}")
        matrix[np.ix_(rows, rows)] = noise[channel].of_track(times[rows])
    return matrix

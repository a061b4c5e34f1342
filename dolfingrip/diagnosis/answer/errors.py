"""What readings differ by beside causes: noise, numbers of the rig, scatter of specimens."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.diagnosis.core.discrepancy import Along

SLACK: Final = "coupon_slack_mm"


@dataclass(frozen=True, eq=False)
class Scatter:
    """How far the specimens differ from one another.

    Attributes:
        scale: relative standard deviation of their stiffness.
        told_scale: as the laboratory told, or usual.
        shape: individual deviation, by the root mean square of a channel.
        estimated: whether the readings of several specimens tell these.
    """

    scale: float
    told_scale: float
    shape: float
    estimated: bool


@dataclass(frozen=True, eq=False)
class Shared:
    """A number of the rig, known to a standard deviation.

    Attributes:
        name: as the laboratory tells it.
        unit: of the number.
        std: told, or usual, in that unit.
        change: of the readings by one standard deviation, shape (n,).
    """

    name: str
    unit: str
    std: float
    change: np.ndarray


@dataclass(frozen=True, eq=False)
class Errors:
    """Everything but causes that readings differ by.

    Attributes:
        covariance: shape (n, n).
        noise: of instruments and gauge, standard deviations, shape (n,).
        along: where the readings lie, for a discrepancy that all specimens share.
        signal: a smooth curve through the readings, shape (n,).
        shared: numbers of the rig.
        fitted: covariance of what a fit gives the rig and each specimen, shape (n, n).
        scatter: of the specimens.
        sentences: where the noise comes from.
        guessed: whether the noise is a guess.
    """

    covariance: np.ndarray
    noise: np.ndarray
    along: Along
    signal: np.ndarray
    shared: tuple[Shared, ...]
    fitted: np.ndarray
    scatter: Scatter
    sentences: tuple[str, ...]
    guessed: bool

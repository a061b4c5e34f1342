"""Barrier energies per area, of the distance of a point from a rigid surface."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dolfingrip.forms.plate import TOUCH


class BarrierValues(NamedTuple):
    """A barrier's energy per area and its derivatives by the distance, each (n,).

    Attributes:
        energy: mJ/mm².
        slope: MPa, minus the contact pressure.
        curvature: MPa/mm.
    """

    energy: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


@dataclass(frozen=True, slots=True)
class Density(ABC):
    """A barrier that is zero from a width on, and infinite at the distance 0.

    Attributes:
        width_mm: ĝ, distance at which contact is first felt.
        stiffness_MPa: κ.
    """

    width_mm: float
    stiffness_MPa: float

    def at(self, gap_mm: np.ndarray) -> BarrierValues:
        """The barrier at positive distances, (n,)."""
        energy, slope, curvature = self._normalised(gap_mm / self.width_mm)
        return BarrierValues(
            self.stiffness_MPa * self.width_mm * energy,
            self.stiffness_MPa * slope,
            self.stiffness_MPa / self.width_mm * curvature,
        )

    @abstractmethod
    def _normalised(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Energy for κ ĝ = 1 and its derivatives by s = g/ĝ, each (n,)."""


class TwoStage(Density):
    """A first quadratic, then logarithmic barrier: see :func:`dolfingrip.forms.plate.energy`.

    It is stiff from the first touch on, so that Newton's method finds a touch in a step.
    """

    __slots__ = ()

    def _normalised(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        near, felt = s < 0.5, s < TOUCH
        energy = np.where(near, -(np.log(2 * s) - 0.5) / 4, (1 - s) ** 2 / 2)
        slope = np.where(near, -1 / (4 * s), s - 1)
        curvature = np.where(near, 1 / (4 * s**2), 1.0)
        return felt * energy, felt * slope, felt * curvature


class Smooth(Density):
    """−κ ĝ (1 − s²)² ln s², s = g/ĝ, as in :class:`~.barrier.BarrierContact` (Li et al. 2020).

    It has no stiffness at first touch, so that points come and go without a jump.
    """

    __slots__ = ()

    def _normalised(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        s = np.minimum(s, 1.0)
        left, log = 1 - s**2, 2 * np.log(s)
        energy = -(left**2) * log
        slope = 4 * s * left * log - 2 * left**2 / s
        curvature = 4 * (1 - 3 * s**2) * log + 16 * left + 2 * left**2 / s**2
        return energy, slope, curvature

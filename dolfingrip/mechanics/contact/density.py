"""Barrier energies per area, of the distance of a point from a rigid surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from dolfingrip.forms.plate import TOUCH


class Felt(NamedTuple):
    """A barrier's energy per area and its derivatives by the distance, each (n,).

    Attributes:
        energy: mJ/mm².
        slope: MPa, minus the contact pressure.
        curvature: MPa/mm.
    """

    energy: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


class Density(Protocol):
    """Zero from a width on, infinite at no distance."""

    @property
    def width_mm(self) -> float:
        """Distance at which contact is first felt."""
        ...

    def at(self, gap_mm: np.ndarray) -> Felt:
        """Of positive distances."""
        ...


@dataclass(frozen=True, slots=True)
class TwoStage:
    """Quadratic at first, then logarithmic: see :func:`dolfingrip.forms.plate.energy`.

    Stiff from the first touch on, so that a touch is found in a step.

    Attributes:
        width_mm: ĝ.
        stiffness_MPa: κ.
    """

    width_mm: float
    stiffness_MPa: float

    def at(self, gap_mm: np.ndarray) -> Felt:
        """See :class:`Density`."""
        s = gap_mm / self.width_mm
        near, felt = s < 0.5, s < TOUCH
        energy = np.where(near, -(np.log(2 * s) - 0.5) / 4, (1 - s) ** 2 / 2)
        slope = np.where(near, -1 / (4 * s), s - 1)
        curvature = np.where(near, 1 / (4 * s**2), 1.0)
        return _felt(self.width_mm, self.stiffness_MPa * felt, energy, slope, curvature)


@dataclass(frozen=True, slots=True)
class Smooth:
    """−κ ĝ (1 − s²)² ln s², s = g/ĝ: that of :class:`~.barrier.BarrierContact` (Li et al. 2020).

    Without stiffness at first touch, so that points come and go without a jump.

    Attributes:
        width_mm: ĝ.
        stiffness_MPa: κ.
    """

    width_mm: float
    stiffness_MPa: float

    def at(self, gap_mm: np.ndarray) -> Felt:
        """See :class:`Density`."""
        s = np.minimum(gap_mm / self.width_mm, 1.0)
        left, log = 1 - s**2, 2 * np.log(s)
        energy = -(left**2) * log
        slope = 4 * s * left * log - 2 * left**2 / s
        curvature = 4 * (1 - 3 * s**2) * log + 16 * left + 2 * left**2 / s**2
        return _felt(self.width_mm, self.stiffness_MPa, energy, slope, curvature)


def _felt(
    width_mm: float,
    stiffness_MPa: float | np.ndarray,
    energy: np.ndarray,
    slope: np.ndarray,
    curvature: np.ndarray,
) -> Felt:
    """Energy and derivatives by the distance, from those by s for κ ĝ = 1."""
    return Felt(
        stiffness_MPa * width_mm * energy,
        stiffness_MPa * slope,
        stiffness_MPa / width_mm * curvature,
    )

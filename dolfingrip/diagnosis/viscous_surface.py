"""Viscosity between the values that it was tried at: near a law in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.model import FreeParameter
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation import relaxation
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.surface import SecantSurface


class ViscousSurface(SecantSurface):
    """The change by viscosity: quasi-linear, and what that misses at the values that were tried.

    A parabola through relaxation times of 2, 13 and 90 s, and readings that are linear in g, are
    far off between these: a fit of τ = 8 s and g = 0.25 began at 6.4 s and 0.31.

    Args:
        problem: the readings; moduli of its base simulation scale.
        candidate, parameters: as for the secants.
    """

    close: ClassVar[bool] = True

    def __init__(
        self, problem: Problem, candidate: Candidate, parameters: Sequence[FreeParameter]
    ) -> None:
        super().__init__(problem, candidate, parameters)
        near = np.array([self._near(place, 1.0) for place in self.places])
        self.follow(self.changes - near)

    def change(self, zeta: Vector, factor: float = 1.0) -> Vector:
        """Of the readings, shape (n,)."""
        return self._near(zeta, factor) + super().change(zeta, factor)

    def _near(self, zeta: Vector, factor: float) -> Vector:
        base = self._problem.base
        found = relaxation.change(base.measurement, base.simulated, self.effect(zeta), factor)
        return self._problem.take(found)

"""The largest principal stretch of a solid, and a smooth function near it."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.forms import peak_stretch
from dolfingrip.forms.kinematics import deformation_gradient
from dolfingrip.mechanics.model.element import integration_degree
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.points import AtPoints
from dolfingrip.mechanics.readings.integrals import OfIntegrals
from dolfingrip.mechanics.readings.principal import largest_eigenvalue


class LargestStretch:
    """The largest principal stretch (–) at the present state.

    Args:
        model: model that is read.
        degree: degree of the integration rule.
        cells: this rank's cells that are looked at; None: all.
    """

    def __init__(self, model: Model, degree: int, cells: np.ndarray | None = None) -> None:
        f = deformation_gradient(model.u)
        self._comm = model.comm
        self._right = AtPoints(f.T * f, model.domain.mesh, degree, cells)

    def value(self) -> float:
        """The stretch, equal on all ranks."""
        values = self._right.values().reshape(-1, 3, 3)
        here = float(np.sqrt(largest_eigenvalue(values).max())) if len(values) else 1.0
        return float(self._comm.allreduce(here, MPI.MAX))


COLUMN = "peak_stretch"


class PeakStretch(OfIntegrals):
    """√(1 + 2 f e): a smooth function of the state near the largest principal stretch (–).

    e = (∫ Σ eᵢ³² dX / ∫ dX)^(1/32) is a mean of the principal strains in which the largest count.
    The factor f makes up for what is below them (Le, Norato, Bruns, Ha & Tortorelli, Struct.
    Multidiscip. Optim. 41, 2010); it is constant in derivatives.

    Args:
        model: model that is read.
        full: whether the full rule integrates it, as the energies.

    Attributes:
        factor: f.
    """

    def __init__(self, model: Model, *, full: bool) -> None:
        space = model.u.function_space
        self._degree = integration_degree(space, full=full)
        self.factor = 1.0
        self._largest = LargestStretch(model, self._degree)
        dx = model.domain.volume(quadrature_degree=self._degree)
        one = fem.Constant(model.domain.mesh, 1.0)
        super().__init__(model, COLUMN, [peak_stretch.power_sum(model.u) * dx, one * dx])

    def fit(self) -> None:
        """Choose the factor with which the value is :meth:`largest` here."""
        strain = self._mean(self._values())
        self.factor = (self.largest() ** 2 - 1) / (2 * strain) if strain > 0 else 1.0

    def _mean(self, integrals: np.ndarray) -> float:
        summed, volume = integrals
        return float((summed / volume) ** (1 / peak_stretch.POWER))

    def _function(self, integrals: np.ndarray) -> float:
        return float(np.sqrt(1 + 2 * self.factor * self._mean(integrals)))

    def _slopes(self, integrals: np.ndarray) -> np.ndarray:
        summed, volume = integrals
        by_strain = self.factor / self._function(integrals)
        slope = by_strain * self._mean(integrals) / peak_stretch.POWER
        return np.array([slope / summed, -slope / volume])

    def largest(self) -> float:
        """The largest principal stretch at the integration points."""
        return self._largest.value()

"""The cavity's volume prescribed, its pressure the multiplier: past limit points."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.model import Control, Model


class VolumeControl:
    """Adds V(u) = V* to a model's equations and the pressure to its unknowns.

    Each Newton step solves the bordered system by elimination with the factors at hand: with
    y = K⁻¹R and z = K⁻¹ ∂V/∂u the step is −y + Δp z, Δp = (V* − V + ∂V/∂u·y) / (∂V/∂u·z)
    (Batoz & Dhatt, Int. J. Numer. Methods Eng. 14, 1979). It is a model's control by the name
    ``cavity_volume_mm3``: a load path leads it as it leads the pressure otherwise.

    Args:
        model: its control ``pressure_kPa`` becomes a result.
        pressure: that control.
        volume: UFL form of the meshed cavity's volume (mm³).

    Attributes:
        force_N: norm of the pressure's load, the scale of the residual.
    """

    def __init__(self, model: Model, pressure: Control, volume: ufl.Form) -> None:
        self._model = model
        self._pressure = pressure
        self._volume = fem.form(volume, jit_options=jit.options())
        test = ufl.TestFunction(model.u.function_space)
        self._gradient = fem.form(ufl.derivative(volume, model.u, test), jit_options=jit.options())
        self._g = fem_petsc.create_vector(self._gradient)
        self._load = model.unknowns.create_vector()
        self._z = self._load.duplicate()
        self._target = self.volume_mm3()
        self._change = 0.0
        self.force_N = 0.0

    # -- as a control ----------------------------------------------------------------------------

    @property
    def value(self) -> float:
        """Prescribed volume of the whole cavity (mm³)."""
        return self._target

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        self._target = value

    # -- in Newton's method ----------------------------------------------------------------------

    def volume_mm3(self) -> float:
        """Present volume of the whole cavity."""
        local = fem.assemble_scalar(self._volume)
        return float(self._model.domain.copies * self._model.comm.allreduce(local, MPI.SUM))

    def met(self, tolerance: float) -> bool:
        """Whether the volume is the prescribed one to a relative ``tolerance``."""
        return abs(self.volume_mm3() - self._target) <= tolerance * abs(self._target)

    def correct(self, y: PETSc.Vec, ksp: PETSc.KSP) -> None:
        """Make SNES' step (x − y) at fixed pressure one that aims at the volume."""
        model = self._model
        with self._g.localForm() as local:
            local.set(0.0)
        fem_petsc.assemble_vector(self._g, self._gradient)
        self._g.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        model.release(self._g)
        self._load.array[: self._g.getLocalSize()] = self._g.array_r
        ksp.solve(self._load, self._z)
        missing = (self._target - self.volume_mm3()) / model.domain.copies
        self._change = (missing + self._load.dot(y)) / self._load.dot(self._z)
        y.axpy(-self._change, self._z)
        pressure = float(self._pressure.constant.value) + self._change
        self.force_N = max(self.force_N, abs(pressure) * self._g.norm())

    def limit(self, step: np.ndarray, fraction: float) -> float:
        """``fraction``: the pressure bounds no step."""
        return fraction

    def advance(self, fraction: float) -> None:
        """Take ``fraction`` of the pressure's change."""
        constant = self._pressure.constant
        constant.value = float(np.asarray(constant.value)) + fraction * self._change

"""Unknowns of the potential that are numbers, not fields: a plate's place on its spring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.model import Model

SMALLEST = 1e-3
"""Size (mm or rad) to which the tolerance of an unknown refers, where it is smaller itself."""


class ScalarUnknowns:
    """Makes constants of a model's potential unknowns for which it is stationary, too.

    Each Newton step solves the bordered system by block elimination with the factors at hand:
    with Z = K⁻¹G, G = ∂²Π/∂u∂s, the unknowns change by (C − GᵀZ)⁻¹ (Gᵀy − ∂Π/∂s), C = ∂²Π/∂s².
    A memory of the model: the unknowns are part of its state.

    Args:
        model: whose potential it is.
        unknowns: scalar constants by name.
        energy: all of the potential that they occur in (mJ of the meshed part).
    """

    def __init__(
        self, model: Model, unknowns: Mapping[str, fem.Constant], energy: ufl.Form
    ) -> None:
        self._model = model
        self._names = tuple(unknowns)
        self._unknowns = tuple(unknowns.values())
        marks = [ufl.variable(constant) for constant in self._unknowns]
        marked = ufl.replace(energy, dict(zip(self._unknowns, marks, strict=True)))
        slopes = [ufl.diff(marked, mark) for mark in marks]
        test = ufl.TestFunction(model.u.function_space)

        def form(integral: ufl.Form) -> fem.Form:
            return fem.form(integral, jit_options=jit.options())

        self._slopes = [form(slope) for slope in slopes]
        self._curvatures = [[form(ufl.diff(slope, mark)) for mark in marks] for slope in slopes]
        self._couplings = [form(ufl.derivative(slope, model.u, test)) for slope in slopes]
        self._g = [fem_petsc.create_vector(coupling) for coupling in self._couplings]
        self._load = model.unknowns.create_vector()
        self._z = [self._load.duplicate() for _ in self._g]
        self._change = np.zeros(len(self._unknowns))
        self.force_N = 0.0

    def _sum(self, form: fem.Form) -> float:
        return float(self._model.comm.allreduce(fem.assemble_scalar(form), MPI.SUM))

    def _get(self) -> np.ndarray:
        return np.array([float(constant.value) for constant in self._unknowns])

    def _set(self, values: Sequence[float] | np.ndarray) -> None:
        for constant, value in zip(self._unknowns, values, strict=True):
            constant.value = float(value)

    def _curvature(self) -> np.ndarray:
        return np.array([[self._sum(form) for form in row] for row in self._curvatures])

    # -- in Newton's method ----------------------------------------------------------------------

    def met(self, tolerance: float) -> bool:
        """Whether the potential is stationary in each unknown to a relative ``tolerance``."""
        scale = np.abs(np.diag(self._curvature())) * np.maximum(np.abs(self._get()), SMALLEST)
        slope = np.array([self._sum(form) for form in self._slopes])
        return bool(np.all(np.abs(slope) <= tolerance * scale))

    def correct(self, y: PETSc.Vec, ksp: PETSc.KSP) -> None:
        """Make SNES' step (x − y) with the unknowns fixed one of the bordered system."""
        for g, z, coupling in zip(self._g, self._z, self._couplings, strict=True):
            with g.localForm() as local:
                local.set(0.0)
            fem_petsc.assemble_vector(g, coupling)
            g.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            self._model.release(g)
            self._load.array[: g.getLocalSize()] = g.array_r
            ksp.solve(self._load, z)
        matrix = self._curvature() - np.array(
            [[self._product(g, z) for z in self._z] for g in self._g]
        )
        rest = [
            self._product(g, y) - self._sum(s) for g, s in zip(self._g, self._slopes, strict=True)
        ]
        self._change = np.linalg.solve(matrix, rest)
        for change, z in zip(self._change, self._z, strict=True):
            y.axpy(float(change), z)

    def _product(self, g: PETSc.Vec, step: PETSc.Vec) -> float:
        """Product of a load with a vector of the model's unknowns, of which u is the first."""
        local = g.array_r @ step.array_r[: g.getLocalSize()]
        return float(self._model.comm.allreduce(local, MPI.SUM))

    def limit(self, step: np.ndarray, fraction: float) -> float:
        """At most ``fraction`` (below 0: backwards) of ``step``; bounds keep a tenth of a gap."""
        gaps = [bound.gap_mm for bound in self._model.bounds if hasattr(bound, "gap_mm")]
        dofs, values = self._model.u.x.array, self._get()
        step = self._model.unknowns.parts(step)[0]
        start, least = dofs.copy(), [0.1 * gap() for gap in gaps]
        try:
            while abs(fraction) > 1e-6:
                dofs[:] = start + fraction * step
                self._set(values + fraction * self._change)
                if all(gap() >= low for gap, low in zip(gaps, least, strict=True)):
                    return fraction
                fraction /= 2
        finally:
            dofs[:] = start
            self._set(values)
        return fraction

    def advance(self, fraction: float) -> None:
        """Take ``fraction`` of the change."""
        self._set(self._get() + fraction * self._change)

    def change(self, constant: fem.Constant) -> float:
        """By how much the present Newton step changes ``constant``; 0 where it is no unknown."""
        changes = zip(self._unknowns, self._change, strict=True)
        return float(sum(change for unknown, change in changes if unknown is constant))

    # -- as a memory -----------------------------------------------------------------------------

    def follow(self, time_s: float, step_s: float) -> None:
        """They have no clock."""

    def accept(self) -> None:
        """They are at the step's end already."""

    def values(self) -> dict[str, np.ndarray]:
        """The unknowns by name."""
        return {
            name: np.array([value]) for name, value in zip(self._names, self._get(), strict=True)
        }

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Set them."""
        self._set([float(values[name][0]) for name in self._names])

"""The pressure field that belongs to a displacement."""

from __future__ import annotations

from typing import Final

import numpy as np
from dolfinx import fem, la
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from dolfingrip.mechanics.model import Model

RTOL: Final = 1e-12
"""Of the pressure's equations."""


class Condensation:
    """Makes a mixed model's Π(u, p) one of u alone, Π(u, p(u)), with p(u) where ∂Π/∂p = 0.

    Of a displacement and a pressure apart one step may well raise Π, which is concave in p; Π of
    the displacement alone falls along each that its tangent leads. Without a pressure field
    nothing is done.

    Args:
        model: with p in a quadratic of its energy, as a perturbed Lagrangian has it.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._ksp = PETSc.KSP().create(model.comm)
        self._ksp.setType(PETSc.KSP.Type.CG)
        self._ksp.getPC().setType(PETSc.PC.Type.JACOBI)  # a mass matrix is well conditioned so
        self._ksp.setTolerances(rtol=RTOL)

    def settle(self) -> None:
        """Set p to p(u) at the present u."""
        p = self._model.p
        if p is None:
            return
        tangent = fem_petsc.assemble_matrix(self._model.potential.coupling[-1])
        tangent.assemble()
        tangent.scale(-1.0)
        constraint = fem.assemble_vector(self._model.potential.constraint)
        constraint.scatter_reverse(la.InsertMode.add)
        change = tangent.createVecLeft()
        right = change.duplicate()
        right.array[:] = constraint.array[: right.getLocalSize()]
        self._ksp.setOperators(tangent)
        self._ksp.solve(right, change)
        p.x.array[: change.getLocalSize()] += change.array_r
        p.x.scatter_forward()

    def led(self, step: np.ndarray) -> np.ndarray:
        """``step`` of the unknowns (a local array), its pressure that of where u then is."""
        unknowns = self._model.unknowns
        start = unknowns.local()
        unknowns.set_local(start + step)
        self.settle()
        end = unknowns.local()
        unknowns.set_local(start)
        return np.asarray(end - start)

"""The pressure field that follows from a displacement."""

from __future__ import annotations

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.policy import LINEAR


class Condensation:
    """Reduces a mixed model's Π(u, p) to Π(u, p(u)), where p(u) solves ∂Π/∂p = 0.

    A step of displacement and pressure together may raise Π, which is concave in p. Π of the
    displacement alone falls along each step of its tangent.

    Args:
        model: a mixed model, quadratic in p like a perturbed Lagrangian.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._ksp = PETSc.KSP().create(model.comm)
        self._ksp.setType(PETSc.KSP.Type.CG)
        self._ksp.getPC().setType(PETSc.PC.Type.JACOBI)  # this makes a mass matrix well conditioned
        self._ksp.setTolerances(rtol=LINEAR.condensation_rtol)

    def step(self) -> np.ndarray:
        """The step (a local array of the unknowns) from p to p(u) at the present u."""
        forms = [term.tangent_forms() for term in self._model.all_terms]
        first, *others = [blocks[-1][-1] for blocks in forms if len(blocks) > 1]
        tangent = fem_petsc.assemble_matrix(first)
        for form in others:
            fem_petsc.assemble_matrix(tangent, form)
        tangent.assemble()
        tangent.scale(-1.0)
        change = tangent.createVecLeft()
        right = change.duplicate()
        right.array[:] = self._model.unknowns.owned_parts(self._model.gradient())[1]
        self._ksp.setOperators(tangent)
        self._ksp.solve(right, change)
        step = np.zeros(self._model.unknowns.owned_size)
        self._model.unknowns.owned_parts(step)[1][:] = change.array_r
        return self._model.unknowns.to_local(step)

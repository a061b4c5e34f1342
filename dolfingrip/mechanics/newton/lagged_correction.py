"""Newton steps along which lagged quantities change: normal forces of friction, for one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.policy import CorrectionPolicy

Solver = Callable[[PETSc.Mat, PETSc.Vec, PETSc.Vec], None]
"""Solves with a matrix and a right-hand side for a solution."""


class CorrectedStep:
    """Solves for the step w of Newton's method with r + K w + C(w) = 0.

    r and K are residual and tangent for fixed lagged quantities, and C is the change of r by their
    change along the step. Its derivative is not symmetric: normal forces, which follow the motion
    along the normals, change forces in the tangent planes. C is not linear, since a point that
    sticks is soon one that slides. It acts on few nodes and costs next to nothing: so its own
    Newton iterations, in which neither elements are assembled nor a matrix is factorised, save
    some with both. Where one of them does not help, as between two states of sliding with sticking
    in the middle, the next takes for C the derivative of what majorises its potential.

    Args:
        model: at the state of r and K.
        tangent: K.
        policy: how it is solved for.
    """

    def __init__(self, model: Model, tangent: PETSc.Mat, policy: CorrectionPolicy) -> None:
        self._policy = policy
        self._model = model
        self._tangent = tangent
        dofs = model.u.x.array
        parts = [term.lagged_correction(dofs) for term in model.lagged_terms]
        self._parts = [part for part in parts if part is not None]
        supported = [bc.dof_indices() for bc in model.supports]
        self._supported = np.concatenate(
            [dofs[:owned] for dofs, owned in supported] or [np.zeros(0, int)]
        )

    @property
    def any(self) -> bool:
        """Whether a term has a correction, the same on all ranks."""
        return bool(self._parts)

    def solve(self, solve: Solver, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve for −w, as SNES has it.

        Args:
            solve: linear solves.
            right: r.
            solution: −w; it starts as anything.
        """
        matrix = PETSc.Mat().createPython(self._tangent.getSizes(), self, comm=self._tangent.comm)
        matrix.setUp()
        solve(matrix, right, solution)
        left, more, trial, error = (right.duplicate() for _ in range(4))
        off, careful = self._error(right, solution, left), False
        enough = self._policy.tolerance * right.norm()
        best, least = solution.copy(), off
        for _ in range(self._policy.solves):
            if off <= enough or not np.isfinite(off):
                break
            self._linearise(solution, convex=careful)
            solve(matrix, left, more)
            more.copy(trial)
            trial.axpy(1.0, solution)
            now = self._error(right, trial, error)
            if not careful and not now <= self._policy.falling * off:
                careful = True
                continue
            careful = False
            trial.copy(solution)
            error.copy(left)
            off = now
            if off < least:
                least = off
                solution.copy(best)
        best.copy(solution)
        for made in (matrix, left, more, trial, error, best):
            made.destroy()

    def mult(self, matrix: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = (K + C') x, as PETSc's matrix of type ``python``."""
        self._tangent.mult(x, y)
        step = self._model.unknowns.to_local(x.array_r)
        y.array[:] += self._sum(lambda part, rate: part.add_rate(step, rate))

    def _error(self, right: PETSc.Vec, solution: PETSc.Vec, error: PETSc.Vec) -> float:
        """Norm of r + K w + C(w), which goes to ``error``."""
        self._tangent.mult(solution, error)
        error.aypx(-1.0, right)
        step = self._model.unknowns.to_local(-solution.array_r)
        error.array[:] += self._sum(lambda part, change: part.add_change(step, change))
        return float(error.norm())

    def _linearise(self, solution: PETSc.Vec, *, convex: bool) -> None:
        step = self._model.unknowns.to_local(-solution.array_r)
        for part in self._parts:
            part.linearise(step, convex=convex)

    def _sum(self, add: Callable[[Any, Gradient], None]) -> np.ndarray:
        """What the terms add by the owned unknowns, 0 in supported rows."""
        found = Gradient(self._model.unknowns)
        for part in self._parts:
            add(part, found)
        found.array[self._supported] = 0.0
        return found.array

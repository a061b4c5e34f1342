"""Newton steps along which lagged quantities change, such as normal forces of friction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.callbacks import context
from dolfingrip.mechanics.newton.policy import CorrectionPolicy

Solver = Callable[[PETSc.Mat, PETSc.Vec, PETSc.Vec], None]
"""A linear solver: it takes a matrix, a right-hand side and the vector of the solution."""


class CorrectedStep:
    """Solves for the step w of Newton's method with r + K w + C(w) = 0.

    r and K are residual and tangent for fixed lagged quantities, and C is the change of r that is
    due to their change along the step. Its derivative is not symmetric: normal forces depend on the
    motion along the normals and change forces in the tangent planes. C is not linear, because a
    point that sticks soon slides. It acts on few nodes and costs almost nothing. Its own Newton
    iterations, which neither assemble elements nor factorise a matrix, therefore save iterations
    that do both. If one of them does not help, as between two states of sliding with sticking in
    the middle, the next one replaces C's derivative by that of a potential that majorises C's.

    Args:
        model: model at the state of r and K.
        tangent: the tangent K.
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
        """Whether a term has a correction, equal on all ranks."""
        return bool(self._parts)

    def solve(self, solve: Solver, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve for −w, the step in SNES' sign.

        Args:
            solve: linear solver.
            right: the residual r.
            solution: −w; its first values do not matter.
        """
        sizes, comm = self._tangent.getSizes(), self._tangent.comm
        matrix = PETSc.Mat().createPython(sizes, context(self.mult), comm=comm)
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
        """y = (K + C') x, for PETSc's matrix of type ``python``."""
        self._tangent.mult(x, y)
        step = self._model.unknowns.to_local(x.array_r)
        y.array[:] += self._sum(lambda part, rate: part.add_rate(step, rate))

    def _error(self, right: PETSc.Vec, solution: PETSc.Vec, error: PETSc.Vec) -> float:
        """Write r + K w + C(w) to ``error`` and return its norm."""
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
        """The sum of the terms' corrections by the owned unknowns; supported rows are 0."""
        found = Gradient(self._model.unknowns)
        for part in self._parts:
            add(part, found)
        found.array[self._supported] = 0.0
        return found.array

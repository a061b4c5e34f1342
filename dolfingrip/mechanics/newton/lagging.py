"""Lagged quantities in Newton's method: their updates, and steps along which they change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.callbacks import context
from dolfingrip.mechanics.newton.policy import CorrectionPolicy, LagPolicy


class LagRules:
    """The rules of one solve.

    Lagged quantities (friction's normal forces and tangent planes) are functions of the solution,
    so they are updated in the first iterations. The equations of a corrected step contain their
    change along the step. They are updated at its end, unless the step overshoots. After a step
    that overshoots, and after any other step, which may also overshoot, they are updated only if
    the residual has fallen since the last update. Close to the solution they are kept as long as
    their lag error is small, which is checked again at the end.

    Args:
        model: model whose terms have lagged quantities.
        policy: when they are updated.
        predicted: whether the solve starts at an estimate of its solution, not at the last
            solution.
        corrected: whether steps may be corrected.

    Attributes:
        current: whether they are those of the present iterate; only then may the next step be
            corrected.
        corrected: whether the last step was corrected; Newton's method sets this.
        overshot: whether a corrected step made the residual grow too much.
    """

    def __init__(
        self, model: Model, policy: LagPolicy, *, predicted: bool = False, corrected: bool = True
    ) -> None:
        self._model = model
        self._policy = policy
        self._peak_N = self._last_N = 0.0
        self._kept = self.current = self.corrected = self.overshot = False
        self._predicted = predicted
        self._repeats, self._corrections = 0, 0 if corrected else self._policy.longest

    @property
    def lost(self) -> bool:
        """True if quantities still lag too far after the state was solved for several times."""
        return self._repeats > self._policy.again

    def is_due(self, norm: float, first_N: float) -> bool:
        """Return whether terms must update their quantities at an iterate that is not the last.

        Args:
            norm: norm of the residual (N).
            first_N: norm at the solve's start.
        """
        at_start = self._peak_N == 0.0
        self._peak_N = max(self._peak_N, norm, first_N)
        fallen = norm <= self._policy.fallen * (self._last_N or first_N)
        self._corrections += self.corrected
        if self.corrected and 0 < self._policy.overshot * self._last_N < norm:
            self.corrected, self.overshot, self._corrections = False, True, self._policy.longest
        due = self.corrected or (at_start and self._predicted)
        due = due or (fallen and (not self._kept or self._is_outdated()))
        self._kept |= norm <= self._policy.close * self._peak_N
        current = due or (at_start and not self._is_outdated())
        self.current = current and not self._kept and self._corrections < self._policy.longest
        self.corrected = False
        return due

    def is_due_at_the_end(self) -> bool:
        """Return whether terms must update their quantities after the solve has converged."""
        outdated = self._is_outdated()
        self._repeats += outdated
        return outdated

    def _is_outdated(self) -> bool:
        return self._model.lag_error() > self._policy.tolerance

    def updated(self, norm: float) -> None:
        """Store the residual (N) after an update."""
        self._last_N = norm


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
        self._supported = model.supported

    @property
    def any(self) -> bool:
        """True if a term has a correction; equal on all ranks."""
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
        residual, more, trial, error = (right.duplicate() for _ in range(4))
        off, careful = self._error(right, solution, residual), False
        enough = self._policy.tolerance * right.norm()
        best, least = solution.copy(), off
        for _ in range(self._policy.solves):
            if off <= enough or not np.isfinite(off):
                break
            self._linearise(solution, convex=careful)
            solve(matrix, residual, more)
            more.copy(trial)
            trial.axpy(1.0, solution)
            now = self._error(right, trial, error)
            if not careful and not now <= self._policy.falling * off:
                careful = True
                continue
            careful = False
            trial.copy(solution)
            error.copy(residual)
            off = now
            if off < least:
                least = off
                solution.copy(best)
        best.copy(solution)
        for made in (matrix, residual, more, trial, error, best):
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
        gradient = Gradient(self._model.unknowns)
        for part in self._parts:
            add(part, gradient)
        gradient.array[self._supported] = 0.0
        return gradient.array

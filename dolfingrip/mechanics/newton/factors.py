"""Linear solves of Newton's method: the inverse of one tangent also serves the next ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import cast

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.newton.cholesky import Cholesky, conjugate_gradients
from dolfingrip.mechanics.newton.ending import Counts
from dolfingrip.mechanics.newton.inverse import Exact, Inverse
from dolfingrip.mechanics.newton.lagging import CorrectedStep
from dolfingrip.mechanics.newton.policy import FactorPolicy


class Factors:
    """Solves with the present matrix, by the inverse of an earlier one as long as that is good.

    Factorising costs about ten times as much as solving. If the matrix has changed a little, GMRES
    (Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) with the earlier factors as preconditioner
    takes a few iterations. If they cost more than a factorisation, the matrix is factorised.
    An approximate inverse, as multigrid is, takes GMRES' iterations for its own matrix, too. If
    these do not converge, factors take its place for good. This is a preconditioner of PETSc's type
    ``python``, which is applied once (``preonly``).

    Args:
        prefix: prefix of PETSc's options.
        inverse: inverse of a matrix.
        policy: how long an inverse serves.
        counts: counts that solves add to.
        spare: returns the inverse that takes the place of one that is not exact and fails.
        spare_policy: how long that one serves.
    """

    def __init__(
        self,
        prefix: str,
        inverse: Inverse,
        policy: FactorPolicy,
        counts: Counts,
        spare: Callable[[], Inverse] | None = None,
        spare_policy: FactorPolicy | None = None,
    ) -> None:
        self._prefix = prefix
        self._policy = policy
        self._counts = counts
        self._inverse = inverse
        self._spare, self._spare_policy = spare, spare_policy or policy
        self._ksp: PETSc.KSP | None = None
        self._factorised: PETSc.Mat | None = None
        self._wanted: PETSc.Mat | None = None
        self._current = False
        self._good = False
        # PETSc's fast product of a vector with several depends on where in memory they are: the
        # same solve would differ in its last digits when a process repeats it. Vectors that are
        # made from here on go without; PETSc warns of an option that nobody reads.
        PETSc.Options()["vec_mdot_use_gemv"] = False
        PETSc.Options().getBool("vec_mdot_use_gemv")

    def renew(self) -> None:
        """Have the next matrix factorised, because it will be far from the last one."""
        self._good = False

    # -- preconditioner of PETSc -------------------------------------------------------------------

    def setUp(self, pc: PETSc.PC) -> None:
        """PETSc calls this after the matrix has changed."""
        self._current = False

    def apply(
        self,
        pc: PETSc.PC,
        right: PETSc.Vec,
        solution: PETSc.Vec,
        correction: CorrectedStep | None = None,
        last_fall: float = np.inf,
    ) -> None:
        """Solve; ``pc`` is marked as failed if the matrix cannot be factorised.

        Args:
            pc: holds the matrix.
            right: right-hand side.
            solution: takes the solution.
            correction: the operator that the matrix is a part of; None if it is the whole.
            last_fall: how far the residual has to fall for this step to be the last one; infinite
                if the end is not near.
        """
        matrix = pc.getOperators()[0]
        ksp = self._ksp or self._create(matrix)
        if correction is not None:
            correction.solve(partial(self._solve_beside, ksp, matrix), right, solution)
        else:
            if not self._solve_near(ksp, matrix, right, solution):
                self._solve_own(ksp, matrix, right, solution)
            if last_fall < 1:
                self._end(ksp, matrix, right, solution, last_fall)
        pc.setFailedReason(self._inverse.failed)

    def _solve_near(
        self, ksp: PETSc.KSP, matrix: PETSc.Mat, right: PETSc.Vec, solution: PETSc.Vec
    ) -> bool:
        """Solve by the inverse of an earlier matrix; return whether that was possible."""
        if self._current or not self._good:
            return False
        ksp.setOperators(matrix)
        ksp.setTolerances(rtol=self._policy.rtol, max_it=self._policy.iterations)
        ksp.solve(right, solution)
        self._good = ksp.getIterationNumber() <= self._policy.worn
        return bool(ksp.getConvergedReason() > 0)

    def _end(
        self,
        ksp: PETSc.KSP,
        matrix: PETSc.Mat,
        right: PETSc.Vec,
        solution: PETSc.Vec,
        last_fall: float,
    ) -> None:
        """Improve the solution until the step can be the last one.

        GMRES' residual is that after the preconditioner, nearly the error of the displacement. What
        is left of the forces may be thousands of times as large.
        """
        residual, more = right.duplicate(), right.duplicate()
        enough = self._policy.last * last_fall * right.norm()
        ksp.setOperators(matrix)
        for _ in range(self._policy.ends):
            matrix.mult(solution, residual)
            residual.aypx(-1.0, right)
            if residual.norm() <= enough:
                break
            ksp.solve(residual, more)
            solution.axpy(1.0, more)
        residual.destroy()
        more.destroy()

    def _solve_own(
        self, ksp: PETSc.KSP, matrix: PETSc.Mat, right: PETSc.Vec, solution: PETSc.Vec
    ) -> None:
        """Solve by the inverse of ``matrix`` itself."""
        if not self._current:
            self._factorise(matrix)
        if not self._inverse.exact:
            if self._solve_fresh(ksp, right, solution, self._policy.rtol):
                return
            self._replace(matrix)
        self._exact.solve(right, solution, self._policy.rtol)

    @property
    def _exact(self) -> Exact:
        return cast(Exact, self._inverse)

    def _solve_fresh(
        self, ksp: PETSc.KSP, right: PETSc.Vec, solution: PETSc.Vec, rtol: float
    ) -> bool:
        """Iterate with an approximate inverse of the matrix itself."""
        ksp.setOperators(self._factorised)
        ksp.setTolerances(rtol=rtol, max_it=self._policy.fresh)
        ksp.solve(right, solution)
        ksp.setTolerances(rtol=self._policy.rtol, max_it=self._policy.iterations)
        return bool(ksp.getConvergedReason() > 0)

    def _replace(self, matrix: PETSc.Mat) -> None:
        """Take factors from here on."""
        assert self._spare is not None
        self._inverse, self._policy = self._spare(), self._spare_policy
        assert self._ksp is not None
        self._ksp.setPC(self._inverse.pc)
        self._factorise(matrix)

    def _solve_beside(
        self,
        ksp: PETSc.KSP,
        matrix: PETSc.Mat,
        operator: PETSc.Mat,
        right: PETSc.Vec,
        solution: PETSc.Vec,
    ) -> None:
        """Solve with an ``operator`` near ``matrix``, by an inverse of this or an earlier one."""
        most = (self._policy.operator_iterations, self._policy.operator_iterations_at_most)
        for fresh in (False, True) if self._good else (True,):
            if fresh and not self._current:
                self._factorise(matrix)
            ksp.setOperators(operator, matrix)
            ksp.setTolerances(rtol=self._policy.operator_rtol, max_it=most[fresh])
            ksp.solve(right, solution)
            done = ksp.getConvergedReason() > 0
            self._good = self._current or ksp.getIterationNumber() <= self._policy.iterations
            ksp.setTolerances(rtol=self._policy.rtol, max_it=self._policy.iterations)
            ksp.setOperators(matrix, matrix)
            if done:
                return
        if not self._inverse.exact:
            self._replace(matrix)
        self._exact.solve(right, solution, self._policy.rtol)

    # -- many right-hand sides ---------------------------------------------------------------------

    def take(self, matrix: PETSc.Mat, *, near: bool) -> None:
        """Let :meth:`solve_many` solve with ``matrix``.

        Args:
            matrix: it must stay as it is until then.
            near: whether good factors of an earlier matrix may serve, else it is factorised.
        """
        if self._ksp is None:
            self._create(matrix)
        self._wanted, self._current = matrix, False
        if not (near and self._good and isinstance(self._inverse, Cholesky)):
            self._factorise(matrix)

    def solve_many(self, right: np.ndarray) -> np.ndarray:
        """Solutions for (n, k) right-hand sides, this rank's rows, (n, k).

        They are good to rounding, and by the factors of an earlier matrix to 1e-7.
        """
        assert self._ksp is not None
        if isinstance(self._inverse, Cholesky) and not self._current:
            assert self._wanted is not None
            limits = self._policy.near_rtol, self._policy.near_iterations
            solutions = conjugate_gradients(self._wanted, self._inverse.approximate, right, *limits)
            if solutions is not None:
                return solutions
            self._factorise(self._wanted)
        if self._inverse.exact:
            return self._exact.solve_many(right)
        assert self._factorised is not None
        solutions = np.zeros_like(right)
        values, solution = self._factorised.createVecs()
        for column in range(right.shape[1]):
            values.array[:] = right[:, column]
            enough = self._policy.exact_left * values.norm()
            # GMRES' residual is that after a V-cycle: what is left is solved for, as far as it goes
            for _ in range(2):
                self._solve_fresh(self._ksp, values, solution, self._policy.exact_rtol)
                solutions[:, column] += solution.array_r
                solution.array[:] = solutions[:, column]
                self._factorised.mult(solution, values)
                values.array[:] = right[:, column] - values.array_r
            if values.norm() > enough:
                self._replace(self._factorised)
                return self.solve_many(right)
        return solutions

    def _create(self, matrix: PETSc.Mat) -> PETSc.KSP:
        self._ksp = ksp = PETSc.KSP().create(matrix.comm)
        ksp.setOptionsPrefix(self._prefix)
        ksp.setType(PETSc.KSP.Type.GMRES)
        ksp.setGMRESRestart(self._policy.restart)
        ksp.setPC(self._inverse.pc)
        ksp.setPCSide(PETSc.PC.Side.LEFT)  # its residual is nearly the error of the displacement
        ksp.setTolerances(rtol=self._policy.rtol, max_it=self._policy.iterations)
        return ksp

    def _factorise(self, matrix: PETSc.Mat) -> None:
        self._inverse.set_up(matrix)
        self._factorised = matrix
        self._current = self._good = True
        self._counts.factorisations += 1
